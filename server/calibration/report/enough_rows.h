#pragma once
// Whether there are rows enough to fit at all, and if not, why.

#include "server/calibration/design/design.h"
#include "server/calibration/model/fit_options.h"

namespace driftwise::calibration {

// Errors: failed_precondition TOO_FEW_ROWS, with how many complete calibration rows there are and
// how many are needed: one more than coefficients with all terms in, two more than those always in
// for a selection. It says what to do: which channel is missing in most rows, or that no row is
// marked calibration.
Result<void> check_enough_rows(const Dataset& dataset, const Design& design,
                               const FitOptions& options);

}  // namespace driftwise::calibration
