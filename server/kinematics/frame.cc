#include "server/kinematics/frame.h"

#include <Eigen/Geometry>

#include "server/core/rotation.h"
#include "server/kinematics/angles.h"

namespace driftwise::kinematics {
namespace {

using Vector = Eigen::Vector3d;

}  // namespace

Frame::Frame(const Eigen::Ref<const Eigen::VectorXd>& values) : translation_(values.head<3>()) {
  const Eigen::AngleAxisd rx(rad_from_deg(values[3]), Vector::UnitX());
  const Eigen::AngleAxisd ry(rad_from_deg(values[4]), Vector::UnitY());
  const Eigen::AngleAxisd rz(rad_from_deg(values[5]), Vector::UnitZ());
  rotation_ = (rz * ry * rx).toRotationMatrix();
  axes_.col(0) = rz * (ry * Vector::UnitX());
  axes_.col(1) = rz * Vector::UnitY();
  axes_.col(2) = Vector::UnitZ();
}

Eigen::Matrix<double, 3, kFrameParameters> Frame::outer_derivatives(const Vector& inner_mm) const {
  Eigen::Matrix<double, 3, kFrameParameters> derivatives;
  derivatives.leftCols<3>().setIdentity();
  const Vector turned = rotation_ * inner_mm;
  for (int i = 0; i < 3; ++i) derivatives.col(3 + i) = kRadPerDeg * axes_.col(i).cross(turned);
  return derivatives;
}

Eigen::Matrix<double, 3, kFrameParameters> Frame::inner_derivatives(const Vector& outer_mm) const {
  Eigen::Matrix<double, 3, kFrameParameters> derivatives;
  derivatives.leftCols<3>() = -rotation_.transpose();
  const Vector beside = outer_mm - translation_;
  for (int i = 0; i < 3; ++i)
    derivatives.col(3 + i) = -kRadPerDeg * (rotation_.transpose() * axes_.col(i).cross(beside));
  return derivatives;
}

void add_frame_parameters(Parameters& parameters, const FrameDescription& frame, double reach_mm,
                          int rank, bool placement) {
  const double natural_deg = deg_from_rad(kNaturalLength_mm / reach_mm);
  parameters.push_back({"frame.x_mm", frame.x_mm, kNaturalLength_mm, rank, placement});
  parameters.push_back({"frame.y_mm", frame.y_mm, kNaturalLength_mm, rank, placement});
  parameters.push_back({"frame.z_mm", frame.z_mm, kNaturalLength_mm, rank, placement});
  parameters.push_back({"frame.rx_deg", frame.rx_deg, natural_deg, rank, placement});
  parameters.push_back({"frame.ry_deg", frame.ry_deg, natural_deg, rank, placement});
  parameters.push_back({"frame.rz_deg", frame.rz_deg, natural_deg, rank, placement});
}

Eigen::Matrix<double, kFrameParameters, 1> frame_values(const Eigen::Matrix3d& rotation,
                                                        const Vector& translation_mm) {
  Eigen::Matrix<double, kFrameParameters, 1> values;
  values.head<3>() = translation_mm;
  values.tail<3>() = rotation_angles_rad(RotationConvention::xyz_fixed, rotation) / kRadPerDeg;
  return values;
}

}  // namespace driftwise::kinematics
