#pragma once
// How far each motor coordinate goes per millimetre of pose: what carries an effect from the motor
// side, where a diagnosis gives its results, to the pose side, where an instrument was wrong.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/result.h"

namespace driftwise::simulation {

// Outputs x axes, mm per mm: the mean slope of the model over its fitted domain along each axis,
// the other channels in the middle of theirs, memory at rest. A mean, so that what is periodic in
// the position does not tilt it; a robot whose slopes change by a share e over the domain leaves a
// share e of what is carried. axes: pose lengths, "x". Errors: failed_precondition NO_DOMAIN (an
// axis that the model does not read); those of effects::TermEvaluator::create.
Result<Eigen::MatrixXd> motor_slopes(const calibration::Model& model,
                                     const std::vector<std::string>& axes);

}  // namespace driftwise::simulation
