#pragma once
// Noise that a coarse thermometer hides: the unknown part of its course acts through every term of
// the baseline that reads it, by the baseline's coefficient. To a search it has a known shape.

#include "server/core/result.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Of a laid-out problem. Columns that add more than a tenth to the noise in their direction, a
// tenth of the learning rows at most. A coefficient counts as far as it is beyond twice its
// standard error: twenty thermometers side by side have large ones of either sign that mean
// nothing.
Result<Hidden> hidden_in(const Problem& problem);

}  // namespace driftwise::diagnosis
