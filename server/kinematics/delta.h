#pragma once
// A delta whose three carriages move along (nearly) vertical axes and carry a platform that only
// translates. Branch i: the carriage's joint stands at c_i + q_i u_i, the arm of length L_i ends at
// the pose p, so that |p - c_i - q_i u_i| = L_i. Joints of the platform are taken into the radius:
// c_i is where the carriage's joint would stand if the arm ended in the pose point itself.
//
//   c_i = (R cos a, R sin a, +- sqrt(L^2 - R^2)): pose zero reads the offset, exactly
//   q   = u.d +- sqrt((u.d)^2 - d.d + L^2), d = p - c; then the scale: (q + offset) (1 + scale)
//
// Reference: R. Clavel, Conception d'un robot parallele rapide, EPFL thesis 925 (1991); the
// form with linear axes as in P. Vischer, EPFL thesis (1996).

#include <array>

#include "server/kinematics/frame.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::kinematics {

class Delta final : public Mechanism {
 public:
  static Result<Delta> create(const KinematicsDescription& description);

  // The other way: the pose at which the three arms meet, on the platform's side. Errors:
  // out_of_range NO_POSE (the arms do not meet).
  Result<Eigen::Vector3d> pose_from_motor(const Eigen::Vector3d& q_mm,
                                          const Eigen::VectorXd& values) const;

 private:
  using Mechanism::Mechanism;
  // x, y, z (mm) -> q1, q2, q3 (mm).
  Prediction evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                      Derivatives derivatives) const override;
};

}  // namespace driftwise::kinematics
