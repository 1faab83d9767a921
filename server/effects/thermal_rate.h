#pragma once
// rate(t07, 300 s), rate2(t07, 300 s): causal filtered derivatives of a temperature, in K/h and
// K/h^2.
//
// Two equal first-order lags in a row, L1 of the input and L2 of L1, time constant tau:
//   rate  = (u - L1) / tau            a ramp of r K/h settles to r
//   rate2 = (u - 2 L1 + L2) / tau^2   a parabola of c K/h^2 settles to c (its second derivative)
// solved exactly for an input that runs straight between readings. Both start at 0, in equilibrium.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind thermal_rate_kind();
EffectKind thermal_rate2_kind();

}  // namespace driftwise::effects
