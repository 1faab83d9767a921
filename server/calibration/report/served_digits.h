#pragma once
// Digits of the form that a model is served in: raw terms times raw coefficients, in double
// precision. The fit works in centred coordinates; far from zero the raw terms are large and cancel
// (x^5 at 2000 mm: 3e16), and of the served sum nothing may be left; nor of the uncertainty, which
// comes from such sums too, the columns of the covariance's root.

#include <Eigen/Core>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/model/model.h"
#include "server/core/result.h"

namespace driftwise::calibration {

// residuals: measured less served, one per row of the design. Errors: failed_precondition
// DIGITS_LOST where their rms exceeds the solution's own by more than 1 % (and by more than
// rounding, where the terms reproduce every row), or where the leverages of the rows, as the served
// root gives them, are not within 1 % those of the orthonormal columns; naming the channel to take
// an offset off.
Result<void> check_served_digits(const Design& design, const Solution& solution,
                                 const Eigen::VectorXd& residuals, const OutputModel& output);

}  // namespace driftwise::calibration
