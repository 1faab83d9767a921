#include "server/application/runs/right_to_move.h"

#include <fmt/format.h>

#include "server/core/reasons.h"

namespace driftwise::application {

// The doors are open for a stop until the axes are at rest; nothing begins to move meanwhile.
Result<void> RightToMove::check_not_ending() const {
  if (!engine_.shutting_down()) return {};
  return fail(ErrorCode::cancelled, reasons::kShuttingDown,
              "the daemon is shutting down and begins no motion: ask again when it has started");
}

Result<void> RightToMove::check(const std::string& lease_token) const {
  if (auto ok = check_not_ending(); !ok) return ok;
  if (auto ok = stops_.check(); !ok) return ok;
  if (auto ok = leases_.check(lease_token, clock_.now().utc); !ok) return ok;
  if (const auto* run = engine_.record())
    return fail(ErrorCode::failed_precondition, reasons::kRunUnderWay,
                fmt::format("run {} '{}' is {}: abort it, or {} until it is over", run->id.value,
                            run->name, to_string(run->state),
                            // A paused one does not end by itself.
                            run->state == RunState::paused ? "resume it and wait" : "wait"));
  if (by_hand_)
    return fail(ErrorCode::failed_precondition, reasons::kMoving,
                "a movement by hand is under way: wait for its end, or stop it");
  return {};
}

Result<void> RightToMove::check_by_hand(const Caller& caller, const std::string& lease_token,
                                        const HoldAnswer& answer) const {
  if (!engine_.stands() || by_hand_) return check(lease_token);
  if (auto ok = check_not_ending(); !ok) return ok;
  if (auto ok = stops_.check(); !ok) return ok;
  if (auto ok = leases_.check(lease_token, clock_.now().utc); !ok) return ok;
  return check_answer(*engine_.record(), engine_.record()->hold, caller.name, answer,
                      clock_.now().utc);
}

}  // namespace driftwise::application
