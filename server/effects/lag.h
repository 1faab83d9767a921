#pragma once
// lag(t07, 1830 s): the structure follows a sensor with a delay. First-order lag
//   tau dL/dt = u - L
// solved exactly for an input that runs straight between readings, so unequal steps need no care:
// the factor is exp(-dt/tau). Unit: the channel's own. Starts in equilibrium with the first value.
// square_lag(speed, 600 s): the same of the square, for losses that grow with the square of a speed
// or a current. Unit: the square of the channel's own.

#include "server/effects/effect.h"

namespace driftwise::effects {

class FirstOrderLag {
 public:
  explicit FirstOrderLag(double tau_s) : tau_s_(tau_s) {}
  double step(double time_s, double input);  // NaN in: NaN out, memory kept

 private:
  double tau_s_;
  bool started_ = false;
  double time_s_ = 0, input_ = 0, lagged_ = 0;
};

EffectKind lag_kind();
EffectKind square_lag_kind();

}  // namespace driftwise::effects
