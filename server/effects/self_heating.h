#pragma once
// heat(q1, 1200 s): heat that the motion of a motor leaves in the structure, which no sensor sees.
// The distance travelled between two readings is spread evenly over the time between them (the move
// before a reading counts, the one after never does), and the store loses what it holds with tau:
//   tau dh/dt = |dq/dt| - h
// Output: h, the mean speed of the last tau, in mm/s of the channel's mm. Starts cold.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind self_heating_kind();

}  // namespace driftwise::effects
