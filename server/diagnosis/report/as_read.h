#pragma once
// The baseline with its thermometers as they were read. The search smooths them, and several smooth
// series with free coefficients describe nearly any slow effect; a model that serves has the
// readings, whose noise its coefficients multiply. Where the two differ on rows held out, slow
// effects may hide in the thermometers' coefficients, and the figures of the baseline are not those
// of the model.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// One sentence per output that is described worse with the readings as they are, on rows held out,
// by more than a quarter beyond the 90 % interval. readings: the dataset that the problem was laid
// out from, in the catalogue's units, row by row the same.
std::vector<std::string> worse_as_read(const Problem& problem, const Dataset& readings);

}  // namespace driftwise::diagnosis
