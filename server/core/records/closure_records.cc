#include "server/core/records/closure_records.h"

#include <array>

namespace driftwise {
namespace {

constexpr std::array<std::string_view, 6> kDecisions{"within", "explained", "play",
                                                     "marked", "repeated",  "new_datum"};

}  // namespace

std::string_view to_string(ClosureDecision decision) {
  return kDecisions[static_cast<std::size_t>(decision)];
}

std::optional<ClosureDecision> closure_decision_from(std::string_view text) {
  for (std::size_t i = 0; i < kDecisions.size(); ++i)
    if (kDecisions[i] == text) return static_cast<ClosureDecision>(i);
  return std::nullopt;
}

}  // namespace driftwise
