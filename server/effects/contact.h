#pragma once
// contact(force): how far two rounded bodies approach under a load, up to a factor: |F|^(2/3) with
// the sign of the force. A ball on a flat or in a groove (feet of a probe, kinematic seats, balls
// of a guide) is soft at first and stiffens: no polynomial of low degree describes its beginning.
// Unit: the channel's own to the power 2/3.
//
// Source: Hertz, J. reine angew. Math. 92 (1882) 156; Johnson, Contact Mechanics (1985), 4.2.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind contact_kind();

}  // namespace driftwise::effects
