#pragma once
// Jog: one axis by a step, or step after step while a button is held. Executor's thread.

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/application/ports/run_hold.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

struct JogOrder {
  std::string channel;  // q1_mm
  double step_mm = 0;   // with its sign
  bool held = false;    // steps follow each other for as long as hold() is heard
};

struct JogState {
  std::int64_t id = 0;
  bool over = false, released = false;  // released: it ended as it was meant to
  std::string end_reason;               // empty while it is under way
  std::vector<double> q_mm;             // as read back last
  std::int64_t steps = 0;               // begun
};

class Jogs {
 public:
  static constexpr double kMostStep_mm = 1;
  // Wall time without hold() after which a held movement is stopped.
  static constexpr std::chrono::milliseconds kSilence{300};

  virtual ~Jogs() = default;
  // Errors: those of ManualControl::move_to; invalid_argument UNKNOWN_AXIS, BAD_STEP. One step: the
  // answer is there when it is done. Held: at once.
  virtual Awaitable<Result<JogState>> begin(Caller caller, std::string lease_token, JogOrder order,
                                            HoldAnswer answer) = 0;
  // Errors of both: not_found NO_SUCH_JOG, also for another one's; permission_denied of the lease.
  virtual Result<JogState> hold(std::int64_t id, const std::string& lease_token) = 0;
  // Stops the axis and answers when the controller has reported no motion, or was told through the
  // stop that survives the daemon (StopDesk).
  virtual Awaitable<Result<JogState>> end(std::int64_t id, std::string lease_token) = 0;
};

}  // namespace driftwise::application
