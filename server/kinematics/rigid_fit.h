#pragma once
// The rotation and translation that bring one set of points closest to another: how a robot stands
// in the frame of the tracker that measured it, before anything else is known.
// Source: S. Umeyama, IEEE Trans. PAMI 13 (1991) 376, without scale.

#include <Eigen/Core>

#include "server/core/result.h"

namespace driftwise::kinematics {

struct RigidFit {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  double rms = 0;  // of the distances left, sqrt(mean |to - (R from + t)|^2)
};

// from, to: 3 x N, N >= 3, in the same order and unit. Errors: failed_precondition TOO_FEW_POINTS,
// POINTS_ON_A_LINE.
Result<RigidFit> fit_rigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

}  // namespace driftwise::kinematics
