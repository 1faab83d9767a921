#pragma once
// From a selection and its solution to what is reported about one output: every offered term, the
// history, the figures.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/stepwise.h"

namespace driftwise::calibration {

// Terms, coefficients, covariance, report, history and the figures that need only the triangle:
// rmse, condition index, F.
OutputModel describe_output(const Design& design, const Triangle& triangle,
                            const Selection& selection, const Solution& solution,
                            Eigen::Index output);

// Sentences for a person: terms that could replace one another, collinear candidates, look-alikes,
// autocorrelation.
std::vector<std::string> output_warnings(const Triangle& triangle, const Selection& selection,
                                         const OutputModel& model);

}  // namespace driftwise::calibration
