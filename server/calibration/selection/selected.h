#pragma once
// From a triangle to the chosen terms of every output and their coefficients.

#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/starts.h"

namespace driftwise::calibration {

struct Fitted {  // one output
  Selection selection;
  std::vector<StartOutcome> starts;
  Solution solution;
};

// Per output of the design. Errors: failed_precondition RANK_DEFICIENT, invalid_argument BAD_VALUE
// (coefficients beyond double precision).
Result<std::vector<Fitted>> select_and_solve(const Design& design, const Triangle& triangle,
                                             const SelectionRule& rule, const Executor& executor);

}  // namespace driftwise::calibration
