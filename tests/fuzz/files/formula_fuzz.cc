// The formula language: any bytes either parse or give an error; what parses prints to the same
// formula again and expands against a file within its limits.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"

using namespace driftwise;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<Channel> channels = {{"q1", "mm"},    {"q2", "mm"},    {"x", "mm"},
                                                {"y", "mm"},     {"force", "N"},  {"t01", "degC"},
                                                {"t02", "degC"}, {"t10", "degC"}, {"air", "degC"}};
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto term = formats::parse_term(text)) {
    const auto again = formats::parse_term(effects::notation(*term));
    if (!again || !(*again == *term)) std::abort();
  }
  const auto formula = formats::Formula::parse(text);
  if (!formula) return 0;
  const auto again = formats::Formula::parse(formula->canonical());
  if (!again || again->canonical() != formula->canonical()) std::abort();
  const auto candidates = formula->expand(channels);
  if (candidates && candidates->terms.size() > formats::FormulaLimits{}.terms + 1) std::abort();
  return 0;
}
