#pragma once
// Permission to begin a run or a movement by hand: the lease, no pending stop, nothing else under
// way. Executor's thread.

#include <optional>
#include <string>

#include "server/application/motion/lease_book.h"
#include "server/application/motion/run_control.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/ports/run_hold.h"
#include "server/application/runs/run_engine.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class RightToMove {
 public:
  RightToMove(asio::any_io_executor executor, Clock& clock, const StopDesk& stops,
              const LeaseBook& leases, RunEngine& engine)
      : executor_(executor),
        clock_(clock),
        stops_(stops),
        leases_(leases),
        engine_(engine),
        beginning_(executor) {}

  // One at a time decides whether a run or a movement may begin.
  Awaitable<AsyncMutex::Lock> turn() { return beginning_.lock(); }

  // Errors: those of StopDesk::check and LeaseBook::check; failed_precondition RUN_UNDER_WAY,
  // MOVING; cancelled SHUTTING_DOWN.
  Result<void> check(const std::string& lease_token) const;
  // The same for a movement by hand, which a run that stands allows to whom it may end.
  Result<void> check_by_hand(const Caller& caller, const std::string& lease_token,
                             const HoldAnswer& answer) const;

  // The movement by hand under way; none: nullptr.
  RunControl* by_hand() { return by_hand_ ? &*by_hand_ : nullptr; }
  const RunControl* by_hand() const { return by_hand_ ? &*by_hand_ : nullptr; }
  RunControl& begin_by_hand() {
    engine_.lend_axes(true);
    return by_hand_.emplace(executor_);
  }
  void end_by_hand() {
    by_hand_.reset();
    engine_.lend_axes(false);
  }

 private:
  Result<void> check_not_ending() const;

  asio::any_io_executor executor_;
  Clock& clock_;
  const StopDesk& stops_;
  const LeaseBook& leases_;
  RunEngine& engine_;
  AsyncMutex beginning_;
  std::optional<RunControl> by_hand_;
};

}  // namespace driftwise::application
