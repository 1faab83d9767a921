#pragma once
// The pose that the motors have by the baseline itself: its formula gives every motor coordinate
// from the pose, and is inverted row by row.
//
// A polynomial in the motors (predicted_pose.h) cannot follow a parallel robot: over 140 mm of a
// delta's travel one of degree 3 misses the pose by micrometres, and a wave of 158 nm has no phase
// there. The baseline misses it by what it leaves of the motors.

#include <map>
#include <string>
#include <vector>

#include "server/core/result.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Pose coordinates, one value per row, in the catalogue's units: the measured pose less what a
// Newton step takes of the baseline's residuals. The coefficients are fitted to the learning rows.
// Rows without a residual keep the measured value. Empty: the outputs are not one motor for each
// pose coordinate, or they do not determine the pose.
// Errors: those of Prepared::columns().
Result<std::map<std::string, std::vector<double>>> inverted_baseline(const Problem& problem);

// Mean square of measured minus predicted over the learning rows. NaN where there are too few.
double mean_square_left(const Problem& problem, const std::string& symbol,
                        const std::vector<double>& predicted);

}  // namespace driftwise::diagnosis
