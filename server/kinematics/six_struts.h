#pragma once
// A parallel robot with six degrees of freedom: six struts of fixed length, each on a carriage that
// moves along a line. Strut i: the carriage's joint stands at c_i + q_i u_i, the platform's joint
// at p + R a_i, and their distance is L_i.
//
//   d = p + R a - c;  q = u.d - sqrt((u.d)^2 - d.d + L^2): the carriage behind its strut
//
// The other way by Newton's method on those six distances. References: J.-P. Merlet, Parallel
// Robots (2006), chapters 3 and 4.

#include <Eigen/Core>
#include <array>

#include "server/core/result.h"

namespace driftwise::kinematics {

constexpr std::size_t kStruts = 6;

struct Strut {
  Eigen::Vector3d base_mm;      // c: the carriage's joint at q = 0
  Eigen::Vector3d direction;    // u, unit length
  Eigen::Vector3d platform_mm;  // a, in the platform's frame; the pose is its origin
  double length_mm = 0;         // L
};

// Rotation R = exp of the rotation vector: no order of axes, and small rotations are their own
// components.
struct SixPose {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
};

class SixStruts {
 public:
  // Errors: invalid_argument BAD_NUMBER (a strut without length, a direction of no length);
  // failed_precondition RANK_DEFICIENT: at pose zero the struts do not hold the platform, saying
  // which motion is free.
  static Result<SixStruts> create(const std::array<Strut, kStruts>& struts);

  // Errors: out_of_range NO_POSE, naming the strut that is too short.
  Result<std::array<double, kStruts>> motors(const SixPose& pose) const;
  // From pose zero, or from a guess. Errors: out_of_range NO_POSE (no convergence).
  Result<SixPose> pose(const std::array<double, kStruts>& q_mm, const SixPose& guess = {}) const;
  // d q_i / d (position mm, rotation rad): nm per nm and per rad of a rotation about the room's
  // axes. Errors: those of motors().
  Result<Eigen::Matrix<double, 6, 6>> jacobian(const SixPose& pose) const;

 private:
  explicit SixStruts(const std::array<Strut, kStruts>& struts) : struts_(struts) {}
  std::array<Strut, kStruts> struts_;
};

// Three pairs of parallel struts along x, y and z; the members of a pair stand apart along y, z and
// x, so that their difference turns the platform about z, x and y. The Sigma6's own dimensions are
// not published: this is its orthogonal arrangement with assumed ones.
std::array<Strut, kStruts> orthogonal_struts(double length_mm, double reach_mm, double spacing_mm);

}  // namespace driftwise::kinematics
