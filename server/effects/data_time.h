#pragma once
// step(14210 s): 0 before this instant of the data's time, 1 from it on: a lost fringe, a slip, a
// change of tool. drift(): the data's time in hours: an instrument whose zero wanders steadily.
// Both belong to the data that they were found in.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind step_kind();
EffectKind drift_kind();

}  // namespace driftwise::effects
