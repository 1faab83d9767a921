#pragma once
// The machine without a run: the lease to move, the stop, movements by hand. Executor's thread.

#include <string>
#include <vector>

#include "server/application/motion/lease_book.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/ports/caller.h"
#include "server/application/ports/run_hold.h"
#include "server/core/devices/loop_tuning.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

struct DeclaredTuning {
  LoopTuning now, declared;  // by its controller, and by the cell file
};
struct TunedStabiliser {
  LoopTuning before, after;
};

class ManualControl {
 public:
  virtual ~ManualControl() = default;

  // token: renews that lease.
  virtual Result<Lease> take_lease(const Caller& caller, Nanoseconds duration,
                                   const std::string& token) = 0;
  virtual Result<void> give_up_lease(const Caller& caller, const std::string& token) = 0;
  // Needs no lease, and ends whosever there is: its holder moves nothing more without a new one. A
  // run under way is paused. Answers within 100 ms. Until every controller has reported no motion
  // the stop is pending: what moves, and Runs::resume, fail with failed_precondition STOP_PENDING.
  // Survives the daemon.
  virtual Awaitable<Result<StopAnswer>> stop_all(Caller caller) = 0;
  // While a run stands both ask as Runs::resume does, and the run measures its zero again before
  // its next point.
  virtual Awaitable<Result<void>> home(Caller caller, std::string lease_token,
                                       HoldAnswer answer = {}) = 0;
  // q_mm: one per axis of the cell; kMissing for the axes of a robot that stays where it is.
  virtual Awaitable<Result<void>> move_to(Caller caller, std::string lease_token,
                                          std::vector<double> q_mm, HoldAnswer answer = {}) = 0;
  virtual Awaitable<Result<void>> set_stabiliser(Caller caller, std::string lease_token,
                                                 std::string device, double degc) = 0;
  // What its controller has now. Errors: not_found NO_STABILISER; those of the device.
  virtual Awaitable<Result<DeclaredTuning>> stabiliser_tuning(std::string device) = 0;
  // Writes what is set. Errors besides: those of set_stabiliser; out_of_range OUT_OF_RANGE.
  virtual Awaitable<Result<TunedStabiliser>> tune_stabiliser(Caller caller, std::string lease_token,
                                                             std::string device,
                                                             LoopTuning wanted) = 0;
};

}  // namespace driftwise::application
