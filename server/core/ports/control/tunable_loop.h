#pragma once
// The control loop of a stabiliser whose controller tells its parameters: a second port of such a
// device, beside Stabiliser.

#include "server/core/devices/loop_tuning.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise {

class TunableLoop {
 public:
  virtual ~TunableLoop() = default;
  virtual LoopTuning declared_tuning() const = 0;  // by the cell file
  virtual Awaitable<Result<LoopTuning>> tuning() = 0;
  // Writes what is set and differs, and reads it back. Answers with what the controller has then.
  // Errors: out_of_range OUT_OF_RANGE (nothing was written), data_loss NOT_TAKEN.
  virtual Awaitable<Result<LoopTuning>> set_tuning(LoopTuning wanted) = 0;
};

}  // namespace driftwise
