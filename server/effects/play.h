#pragma once
// play(q2, 85 nm): what a play of this full width leaves behind on the observed path of q2.
//
// The play operator of the theory of hysteresis (Krasnosel'skii and Pokrovskii 1989): the driven
// side y stays where it is until the drive q has taken up half the width on either side,
//   y_k = min(max(y_{k-1}, q_k - w/2), q_k + w/2),
// exact between readings as long as each move runs one way. Output: y - q, in the unit of q, within
// +-w/2; a coefficient of 1 is a play in the drive as it stands. Starts in the middle.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind play_kind();

}  // namespace driftwise::effects
