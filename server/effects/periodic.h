#pragma once
// sin(x, 316.4 nm), cos(x, 316.4 nm): periodic in a length, as the interpolation of a scale or an
// interferometer is. sin_t(600 s), cos_t(600 s): periodic in the data's own time. Output between -1
// and 1, without unit. The phase is taken from whole periods first, so a period of nanometres keeps
// its digits over metres.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind sine_kind();
EffectKind cosine_wave_kind();
EffectKind sine_in_time_kind();
EffectKind cosine_in_time_kind();

}  // namespace driftwise::effects
