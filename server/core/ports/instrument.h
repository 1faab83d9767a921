#pragma once

#include "server/core/ports/device.h"

namespace driftwise {

// Something that is read: scanner, interferometer.
class Instrument : public Device {
 public:
  // One reading of all its channels. A scanner's probe that is open or broken is kMissing, not an
  // error. An interferometer gives <length> in mm and <symbol>_std_nm of its averaged samples, and
  // fails with failed_precondition, reason BEAM_LOST, when the length can no longer be trusted
  // until it is zeroed.
  virtual Awaitable<Result<Reading>> read() = 0;
  // Makes the present value the zero, where the instrument has one; else failed_precondition,
  // NO_ZERO.
  virtual Awaitable<Result<void>> zero() = 0;
  // False: its zero is kept in this process, and there has been none since the start. A length then
  // counts from anywhere, and says nothing about a zero of before.
  virtual bool knows_its_zero() const { return true; }
};

}  // namespace driftwise
