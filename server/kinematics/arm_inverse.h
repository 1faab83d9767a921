#pragma once
// Joint angles that bring a serial arm's tool to a pose, with all errors of its joints in: the
// inverse of SerialArm::posture(), by damped Newton steps from the angles given and from 256 drawn
// ones (seeded, so the same question has the same answer).
//
// Source of the damping: Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108 (1986) 163.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/kinematics/serial_arm.h"

namespace driftwise::kinematics {

struct WantedPose {  // in the measuring frame
  Eigen::Vector3d point_mm;
  std::optional<Eigen::Matrix3d> axes;  // of the last link; needed by six joints
};

struct JointSolution {
  std::vector<double> joints;  // in the channels' units
  double miss_nm = 0;          // of the forward model at these angles: the point ...
  double miss_arcsec = 0;      // ... and the axes; 0 without
  int solutions = 0;           // different ones found, turns of 360 degrees apart counted once
  double least_motion = 0;     // of the tool per turn of the joints over the arm's reach: smallest
                               // singular value of the Jacobian
};

// A pose where some turn of the joints of one radian moves the tool by less than this share of the
// arm's reach is near a singular one.
inline constexpr double kLeastMotion = 0.01;

// Of all solutions the nearest to `near` (root of the sum of squares of the joints' differences,
// each joint at the turn of 360 degrees nearest to it). values: one per parameter. temperatures:
// one per drift channel. Errors: invalid_argument BAD_KINEMATICS (joints that are not 3 or 6, six
// without axes); NO_POSE: out_of_range, nothing reaches it; failed_precondition, near a singular
// pose, with its name (wrist, elbow, shoulder).
Result<JointSolution> nearest_joints(const SerialArm& arm, const Eigen::VectorXd& values,
                                     const WantedPose& wanted, std::span<const double> near,
                                     std::span<const double> temperatures);

}  // namespace driftwise::kinematics
