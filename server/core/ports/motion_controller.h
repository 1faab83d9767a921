#pragma once

#include <span>
#include <vector>

#include "server/core/ports/device.h"

namespace driftwise {

struct MotionState {
  CellTime at;               // when the controller answered
  std::vector<double> q_mm;  // as read back from the scales, one per axis of the description
  bool moving = false, referenced = false, on_target = false;
};

class MotionController : public Device {
 public:
  virtual Awaitable<Result<MotionState>> state() = 0;
  // References all axes and returns when that is done (or failed): bounded by progress, not by a
  // fixed time.
  virtual Awaitable<Result<void>> home() = 0;
  // Starts a move of all axes in one command and returns when the controller has accepted it.
  // Errors: out_of_range (soft limits, checked here again; nothing is sent), failed_precondition
  // (not referenced, servo off), aborted (stopped).
  virtual Awaitable<Result<void>> start_move(std::span<const double> q_mm) = 0;
  // Halts all axes now. May be called while another call is under way, which then fails with
  // aborted. Success means that the controller has the command, not that nothing moves: state()
  // says so. Until state() has reported no motion in two successive answers, the command is also
  // the first one on every new connection.
  virtual Awaitable<Result<void>> stop() = 0;
};

}  // namespace driftwise
