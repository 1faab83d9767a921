#pragma once
// Outputs that are read in steps larger than their noise: a laser's display of 0.1 um before an
// axis that repeats within 20 nm. The rounding errors are then no noise. They go with the place,
// lie on two sides of it or are loud where an edge is near, and probe_hysteresis, noise_change and
// outliers are named for them.
//
// A reading says within which step the value was; the simulation with what was found, and its
// noise, say where in it. The search is given a value drawn from that (a truncated normal law;
// simulation and noise by the EM algorithm for grouped data: Dempster, Laird and Rubin, J. R. Stat.
// Soc. B 39 (1977) 1, section 4.2). Figures stay those of the readings.

#include <string>
#include <vector>

#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// The largest 1, 2 or 5 times a power of ten of which all values are multiples; 0: none above a
// millionth of their range. At least 16 of them.
double decimal_step(const std::vector<double>& values);

// Frees the outputs of their rounding where they, or of a motor the pose coordinate behind it, are
// read in steps of more than twice their noise; but positions that a plan sets: their steps are
// the plan's.
// Returns a sentence for each; none: nothing was changed. given: the dataset in its own units.
// found: of a diagnosis of the same problem; none: by the baseline alone, and then only where the
// noise is below a fifth of a step.
Result<std::vector<std::string>> free_of_rounding(Problem& problem, const Dataset& given,
                                                  const std::vector<Finding>& found);

}  // namespace driftwise::diagnosis
