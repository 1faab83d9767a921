#include "server/core/reasons.h"

#include <algorithm>
#include <array>

namespace driftwise {
namespace {

// Those of the table with a recovery of their own; tests/unit/house compares the two.
constexpr std::array kWithRecovery = {
    reasons::kBeamLost,          reasons::kDriftTooFast, reasons::kKeepOut,
    reasons::kMissingCoordinate, reasons::kNoController, reasons::kNoLoad,
    reasons::kNoModel,           reasons::kNoZero,       reasons::kRunAborted,
    reasons::kServoOff,          reasons::kShuttingDown, reasons::kStabiliserOff,
    reasons::kZeroNotReached};

}  // namespace

Recovery recovery_of(std::string_view reason) {
  const auto found = std::ranges::find(kWithRecovery, reason, &Reason::view);
  return found == kWithRecovery.end() ? Recovery::by_code : found->recovery;
}

}  // namespace driftwise
