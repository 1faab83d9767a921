#pragma once
// Memory of an effect in time.

#include "server/effects/term.h"

namespace driftwise::effects {

// The memory of an effect counts as known once its channels were seen for so many time constants:
// exp(-5), 0.7 %, is left of what was before. After kForgottenTaus nothing is.
inline constexpr double kKnownTaus = 5, kForgottenTaus = 10;

// Time constant of an effect's memory in seconds; 0: it has none. Of an effect that is not known:
// 0.
double tau_s(const Call& call);

}  // namespace driftwise::effects
