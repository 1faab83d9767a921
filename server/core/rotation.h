#pragma once
// Rotations by three angles in the conventions that robots and instruments use, and rigid
// transformations. Right-handed, active: p_base = R p_body.

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "server/core/result.h"

namespace driftwise {

// How three numbers a, b, c (rad) stand for R:
//   xyz_fixed       about the fixed axes x, then y, then z: R = Rz(c) Ry(b) Rx(a). "Roll, pitch,
//                   yaw" of ROS and URDF; as a moving sequence it is z-y'-x''.
//   xyz_moving      about the body's own axes x, then y, then z: R = Rx(a) Ry(b) Rz(c).
//   zyx_moving      about the body's own axes z, then y, then x: R = Rz(a) Ry(b) Rx(c).
//   zyz_moving      R = Rz(a) Ry(b) Rz(c).
//   rotation_vector axis times angle.
enum class RotationConvention : std::uint8_t {
  xyz_fixed,
  xyz_moving,
  zyx_moving,
  zyz_moving,
  rotation_vector
};

// "xyz-fixed", ... Errors: invalid_argument UNKNOWN_CONVENTION.
Result<RotationConvention> rotation_convention(std::string_view name);
std::string_view to_string(RotationConvention convention);

Eigen::Matrix3d rotation_matrix(RotationConvention convention, const Eigen::Vector3d& angles_rad);
// The angles of R: the middle one within [-pi/2, pi/2] (zyz: [0, pi]), the others and the vector's
// length within [-pi, pi]. Where the middle angle, within 1e-8 rad, makes the other two
// indistinguishable the third is 0, of zyx_moving the first.
Eigen::Vector3d rotation_angles_rad(RotationConvention convention, const Eigen::Matrix3d& rotation);

// p_out = rotation p_in + translation_mm.
struct RigidTransform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();

  RigidTransform operator*(const RigidTransform& inner) const {
    return {rotation * inner.rotation, rotation * inner.translation_mm + translation_mm};
  }
  RigidTransform inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation_mm)};
  }
};

// The rotation nearest to a matrix that was written with few digits (its polar factor).
// Errors: invalid_argument NOT_A_ROTATION when an element would move by more than 1e-3, or for a
// reflection.
Result<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& matrix);

}  // namespace driftwise
