#pragma once
// The best of several starts: stepwise selection goes downhill one term at a time and may stop in a
// local optimum (the published 4th-order model did: it left out terms that only help together).
//
// Starts, in this order: "none" (what must be in), "all" (every candidate that can be estimated, in
// order; not tried where the rows would leave fewer than two degrees of freedom), "random 3", ...:
// each candidate with probability 1/2, less where rows are few; with hierarchy a term's parents
// come with it. From each start the same rule runs to its end. The winner has the lowest BIC
// (criterion aic: the lowest AIC) on the calibration rows; within 1e-7 the earlier start wins. The
// random subsets follow from the seed alone, the same on every machine and for every executor.

#include <string>
#include <vector>

#include "server/calibration/model/fit_options.h"
#include "server/calibration/selection/stepwise.h"

namespace driftwise::calibration {

struct BestSelection {
  Selection selection;
  std::vector<StartOutcome> starts;  // empty when there was one start only
};

// As select(), from rule.starts starts. triangle outlives the result.
BestSelection select_from_starts(const Triangle& triangle, const Basis& basis,
                                 const std::vector<char>& always, Eigen::Index output,
                                 const SelectionRule& rule, const Executor& executor = {});

}  // namespace driftwise::calibration
