#pragma once
// A rigid placement by three translations and three rotations, with its derivatives.
// p_outer = R p_inner + t, R = Rz(rz) Ry(ry) Rx(rx).

#include <Eigen/Core>

#include "server/core/description/kinematics_description.h"
#include "server/kinematics/parameter.h"

namespace driftwise::kinematics {

constexpr int kFrameParameters = 6;  // x, y, z (mm), rx, ry, rz (deg), in this order

class Frame {
 public:
  // values: the six, in order.
  explicit Frame(const Eigen::Ref<const Eigen::VectorXd>& values);

  Eigen::Vector3d outer(const Eigen::Vector3d& inner_mm) const {
    return rotation_ * inner_mm + translation_;
  }
  Eigen::Vector3d inner(const Eigen::Vector3d& outer_mm) const {
    return rotation_.transpose() * (outer_mm - translation_);
  }
  // Of outer() with respect to the six, and of inner(); per mm and per degree.
  Eigen::Matrix<double, 3, kFrameParameters> outer_derivatives(
      const Eigen::Vector3d& inner_mm) const;
  Eigen::Matrix<double, 3, kFrameParameters> inner_derivatives(
      const Eigen::Vector3d& outer_mm) const;
  const Eigen::Matrix3d& rotation() const { return rotation_; }

 private:
  Eigen::Vector3d translation_;
  Eigen::Matrix3d rotation_;
  Eigen::Matrix3d axes_;  // columns: the axes that rx, ry, rz turn about, in the outer frame
};

// frame.x_mm ... frame.rz_deg. reach_mm: how far away the robot works, for the natural angle.
void add_frame_parameters(Parameters& parameters, const FrameDescription& frame, double reach_mm,
                          int rank, bool placement);

// The six values of a rotation and a translation. Where ry is +-90 degrees, within 1e-8 rad, rx and
// rz are indistinguishable: rz is 0 there.
Eigen::Matrix<double, kFrameParameters, 1> frame_values(const Eigen::Matrix3d& rotation,
                                                        const Eigen::Vector3d& translation_mm);

}  // namespace driftwise::kinematics
