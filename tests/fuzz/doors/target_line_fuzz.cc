// Any line: an error, or a request whose numbers are finite and whose answer is one line.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "server/formats/export/target_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const auto request = formats::parse_target_line({reinterpret_cast<const char*>(data), size});
  std::string answer;
  if (!request) {
    formats::append_error_answer(answer, request.error());
  } else {
    for (const double value : request->value)
      if (!std::isfinite(value)) std::abort();
    const compensation::Snapshot none;
    formats::append_target_answer(answer, none, compensation::compute_target(none, *request), true);
  }
  if (answer.find('\n') != answer.size() - 1) std::abort();
  return 0;
}
