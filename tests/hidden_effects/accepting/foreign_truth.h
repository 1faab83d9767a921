#pragma once
// Truth of a data set of the independent population, for the judgement of a served target: where
// the end-effector was, and the motor coordinates there, both without noise.
//
// Frame: the poses count from a zero of the instruments at pose 0 in the conditions of the first
// row, as a datum does (server/correction/data_amendment.h). Noise is the instruments'.

#include "tests/hidden_effects/accepting/served_truth.h"
#include "tests/hidden_effects/foreign/generate.h"

namespace driftwise::hidden {

// An effect in no catalogue is written as an error of the readings, but most of its descriptions
// are of the robot (a mount, a guide, a joint): either may be meant.
enum class UnlistedEffectOf : std::uint8_t { robot, instruments };

bool holds_rows_out(const Dataset& data);

// Five blocks of a twenty-fifth of the rows each, evenly spread, the last at the end of the data:
// marked as kept out of fits. Neither the fit nor the diagnosis learns from them. The last fifth of
// a lattice in line order would lie at places that the fit never saw.
void withhold_rows(Dataset& data);

// Judged are the validation rows; where the plan holds none out, those that are kept out of fits.
TrueRows foreign_truth(const foreign::Generated& made, const Dataset& data, CellTime time_zero,
                       UnlistedEffectOf unlisted);

}  // namespace driftwise::hidden
