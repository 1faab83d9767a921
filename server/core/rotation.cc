#include "server/core/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "server/core/reasons.h"

namespace driftwise {
namespace {

using Eigen::AngleAxisd, Eigen::Matrix3d, Eigen::Vector3d;

constexpr std::array<std::pair<std::string_view, RotationConvention>, 5> kConventions = {
    {{"xyz-fixed", RotationConvention::xyz_fixed},
     {"xyz-moving", RotationConvention::xyz_moving},
     {"zyx-moving", RotationConvention::zyx_moving},
     {"zyz-moving", RotationConvention::zyz_moving},
     {"rotation-vector", RotationConvention::rotation_vector}}};

// Sine or cosine of the middle angle below which the other two angles count as indistinguishable.
// What is left of them has this size, of a matrix element. Above it the matrix' rounding, 1e-16,
// divided by it turns the two by at most 1e-8 rad.
constexpr double kHidden = 1e-8;

Matrix3d about(int axis, double angle_rad) {
  return AngleAxisd(angle_rad, Vector3d::Unit(axis)).toRotationMatrix();
}

// R = Rz(yaw) Ry(pitch) Rx(roll), as (roll, pitch, yaw).
Vector3d roll_pitch_yaw(const Matrix3d& r) {
  const double cosine = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), cosine);
  if (cosine < kHidden)  // only yaw minus (or plus) roll shows: yaw is 0
    return {std::atan2(-r(1, 2), r(1, 1)), pitch, 0};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace

Result<RotationConvention> rotation_convention(std::string_view name) {
  std::string known;
  for (const auto& [text, convention] : kConventions) {
    if (text == name) return convention;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  return fail(ErrorCode::invalid_argument, reasons::kUnknownConvention,
              "found '" + std::string(name) + "', expected one of " + known);
}

std::string_view to_string(RotationConvention convention) {
  for (const auto& [text, value] : kConventions)
    if (value == convention) return text;
  return "";
}

Matrix3d rotation_matrix(RotationConvention convention, const Vector3d& a) {
  switch (convention) {
    case RotationConvention::xyz_fixed:
      return about(2, a.z()) * about(1, a.y()) * about(0, a.x());
    case RotationConvention::xyz_moving:
      return about(0, a.x()) * about(1, a.y()) * about(2, a.z());
    case RotationConvention::zyx_moving:
      return about(2, a.x()) * about(1, a.y()) * about(0, a.z());
    case RotationConvention::zyz_moving:
      return about(2, a.x()) * about(1, a.y()) * about(2, a.z());
    case RotationConvention::rotation_vector:
      break;
  }
  const double angle_rad = a.norm();
  if (angle_rad == 0) return Matrix3d::Identity();
  return AngleAxisd(angle_rad, a / angle_rad).toRotationMatrix();
}

Vector3d rotation_angles_rad(RotationConvention convention, const Matrix3d& r) {
  switch (convention) {
    case RotationConvention::xyz_fixed:
      return roll_pitch_yaw(r);
    case RotationConvention::xyz_moving:
      // The transpose is Rz(-c) Ry(-b) Rx(-a).
      return -roll_pitch_yaw(r.transpose());
    case RotationConvention::zyx_moving: {
      const Vector3d fixed = roll_pitch_yaw(r);
      return {fixed.z(), fixed.y(), fixed.x()};
    }
    case RotationConvention::zyz_moving: {
      const double sine = std::hypot(r(0, 2), r(1, 2));
      if (sine < kHidden) {
        const double turned = r(2, 2) < 0 ? -1 : 1;  // Ry(pi) turns x and z round
        return {std::atan2(turned * r(1, 0), turned * r(0, 0)), std::atan2(sine, r(2, 2)), 0};
      }
      return {std::atan2(r(1, 2), r(0, 2)), std::atan2(sine, r(2, 2)),
              std::atan2(r(2, 1), -r(2, 0))};
    }
    case RotationConvention::rotation_vector:
      break;
  }
  const AngleAxisd turn(r);
  return turn.axis() * turn.angle();
}

Result<Matrix3d> nearest_rotation(const Matrix3d& matrix) {
  if (matrix.allFinite() && matrix.determinant() > 0) {
    const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
    if (rotation.determinant() > 0 && (rotation - matrix).cwiseAbs().maxCoeff() <= 1e-3)
      return rotation;
  }
  return fail(ErrorCode::invalid_argument, reasons::kNotARotation,
              "found a matrix that is no rotation, expected orthonormal rows and columns and a "
              "determinant of 1");
}

}  // namespace driftwise
