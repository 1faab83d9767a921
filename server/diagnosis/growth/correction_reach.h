#pragma once
// How well the data know what an accepted correction would take off a length. A tilt that goes with
// the pose, or air that goes with the thermometers, is mostly described by the simulation already:
// a finding of 2 nm beyond it can stand for a correction of 2 um whose size is known to 0.4 um.

#include <optional>
#include <vector>

#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/rows/weighted_fit.h"
#include "server/effects/term.h"

namespace driftwise::diagnosis {

struct CorrectionReach {  // over the calibration rows, in the output's summary unit
  double rms = 0;         // of the sum of the terms
  double u90 = 0;         // of what is uncertain in it
};

// Counted from where the measurement began (correction/first_conditions.h). fit: whose added
// columns they are. Nothing where one of them is not determined at all.
std::optional<CorrectionReach> correction_reach(const Problem& problem,
                                                const std::vector<effects::Term>& terms,
                                                const WeightedFit& fit);

}  // namespace driftwise::diagnosis
