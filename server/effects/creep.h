#pragma once
// creep(q1, dwell, 300 s): relaxation after a move. Each move leaves a remainder proportional to
// its length, which dies away with tau:
//   c_k = (c_{k-1} exp(-(dt - dwell)/tau) + q_k - q_{k-1}) exp(-dwell/tau)
// with dwell the time between the end of the move and the reading, and dt the time since the last
// reading. Output: c, in the unit of q. Starts at rest.
// creep(q1, 300 s): readings follow each move's end after the same time, which is then a factor of
// the amplitude: dwell 0.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind creep_kind();

}  // namespace driftwise::effects
