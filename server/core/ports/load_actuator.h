#pragma once

#include "server/core/ports/device.h"

namespace driftwise {

struct LoadState {
  CellTime at;          // when the actuator answered
  double force_n = 0;   // what pulls at the end-effector now
  bool resting = true;  // false while weights are on their way
};

// Something that changes the force on the end-effector: known weights laid on and taken off.
class LoadActuator : public Device {
 public:
  virtual Awaitable<Result<LoadState>> state() = 0;
  // Returns when the actuator has accepted it; the force is there when state() rests at it. Errors
  // besides those of every device: out_of_range (the actuator has no such load; nothing moves).
  virtual Awaitable<Result<void>> set_force(double force_n) = 0;
};

}  // namespace driftwise
