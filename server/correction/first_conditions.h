#pragma once
// A length's scale that goes with something sensed is the same robot at another scale until one
// says from where it counts. `x * pressure` with 0.2 nm/mm/hPa is 200 ppm at 965 hPa, and a laser
// is not 200 ppm wrong: it was told the conditions when the measurement was set up, and is wrong by
// what has changed since.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/effects/term.h"

namespace driftwise::correction {

// Every product of pose coordinates and other channels, c P S, becomes c P (S - S0): the term P
// with - c S0 joins the list, S0 what S was in the first row of the data where it is known. Terms
// of the pose alone, of others alone and of the data's clock stay as they are. mm: one per term,
// kept in step. Errors: those of effects::TermEvaluator::create.
Result<void> count_from_first(const Dataset& dataset, std::vector<effects::Term>& terms,
                              std::vector<double>& mm);

}  // namespace driftwise::correction
