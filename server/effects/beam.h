#pragma once
// What an interferometer's beam adds, as columns.
//
// cosine(x, ry, rz): x (1 - cos ry cos rz), in the unit of x: the share of the path along a mirror
// that tilts by ry, rz arcsec. air_index(air, pressure, humidity): refractivity of air n - 1 in
// parts per million at 633 nm, for degC, hPa and percent, by the modified Edlen equation (Birch and
// Downs 1993, corrected 1994; Metrologia 30, 155 and 31, 315): times the dead path it is the error
// of a length whose air correction leaves that path out.

#include "server/effects/effect.h"

namespace driftwise::effects {

EffectKind cosine_error_kind();
EffectKind air_index_kind();

}  // namespace driftwise::effects
