#pragma once
// Where an arm stands in the measuring frame, before anything else is known: a tracker may stand
// anywhere. Parameters that the robot file holds keep their values.

#include <Eigen/Core>

#include "server/core/result.h"
#include "server/kinematics/parameter.h"

namespace driftwise::identification {

// points, measured: 3 x N, mm, in the same order; points as the arm gives them with its frame at
// zero. parameters: the arm's, the frame's six first (kinematics/frame.h). Result: the frame's six
// values; those that are not held bring the points closest to the measured ones, of all turns.
// Errors: those of kinematics::fit_rigid.
Result<Eigen::VectorXd> frame_start(const Eigen::Matrix3Xd& points,
                                    const Eigen::Matrix3Xd& measured,
                                    const kinematics::Parameters& parameters);

}  // namespace driftwise::identification
