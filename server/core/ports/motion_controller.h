#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "server/core/ports/device.h"

namespace driftwise {

struct MotionState {
  CellTime at;               // when the controller answered
  std::vector<double> q_mm;  // as read back from the scales, one per axis of the description
  bool moving = false, referenced = false, on_target = false;
  bool servo_on = true;  // false: a drive was found without current; only home() switches it on
  // The controller's own reason for the end of the last motion, number and text; empty: it has
  // given none.
  std::string halted_because = {};
  // An error of the controller that is no answer to a command: what it held before one, or at the
  // end of a motion. In one state only.
  std::string old_error = {};

  // One more controller: the axes of both, moving where one moves, at rest where both are.
  void join(const MotionState& other) {
    at = std::max(at, other.at);
    q_mm.insert(q_mm.end(), other.q_mm.begin(), other.q_mm.end());
    moving = moving || other.moving;
    referenced = referenced && other.referenced;
    on_target = on_target && other.on_target;
    servo_on = servo_on && other.servo_on;
    if (halted_because.empty()) halted_because = other.halted_because;
  }
};

class MotionController : public Device {
 public:
  virtual Awaitable<Result<MotionState>> state() = 0;
  // Switches the drives on, references all axes and returns when that is done (or failed): bounded
  // by progress, not by a fixed time. The only call that gives a drive its current.
  virtual Awaitable<Result<void>> home() = 0;
  // Starts a move of all axes in one command and returns when the controller has accepted it.
  // Errors: out_of_range (soft limits, checked here again; nothing is sent), failed_precondition
  // (NOT_REFERENCED, SERVO_OFF), aborted (stopped).
  virtual Awaitable<Result<void>> start_move(std::span<const double> q_mm) = 0;
  // Halts all axes now. May be called while another call is under way, which then fails with
  // aborted. Success means that the controller has the command, not that nothing moves: state()
  // says so. Until state() has reported no motion in two successive answers, the command is also
  // the first one on every new connection.
  virtual Awaitable<Result<void>> stop() = 0;
};

}  // namespace driftwise
