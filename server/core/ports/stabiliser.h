#pragma once

#include "server/core/ports/device.h"

namespace driftwise {

// A temperature controller with its own loop: a Peltier element on an interferometer's support.
class Stabiliser : public Device {
 public:
  // Channels <id>_degC, <id>_set_degC, <id>_power_pct (the id with '-' as '_').
  virtual Awaitable<Result<Reading>> read() = 0;
  virtual Awaitable<Result<void>> set_point(double degc) = 0;  // writes only a changed value
};

}  // namespace driftwise
