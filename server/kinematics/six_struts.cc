#include "server/kinematics/six_struts.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"

namespace driftwise::kinematics {
namespace {

Eigen::Matrix3d rotation_from(const Eigen::Vector3d& vector_rad) {
  const double angle = vector_rad.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector_rad / angle).toRotationMatrix();
}

Eigen::Vector3d vector_from(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace

Result<SixStruts> SixStruts::create(const std::array<Strut, kStruts>& struts) {
  SixStruts made(struts);
  for (std::size_t i = 0; i < kStruts; ++i) {
    auto& strut = made.struts_[i];
    const double norm = strut.direction.norm();
    if (!(strut.length_mm > 0) || !(norm > 0) || !std::isfinite(norm))
      return fail(ErrorCode::invalid_argument, reasons::kBadNumber,
                  "strut " + std::to_string(i + 1) +
                      ": expected a length above 0 and a direction of its carriage");
    strut.direction /= norm;
  }
  DRIFTWISE_TRY(const auto slopes, made.jacobian({}));
  // Rotations at the struts' own scale, or the condition would depend on the unit.
  Eigen::Matrix<double, 6, 6> scaled = slopes;
  scaled.rightCols<3>() /= struts[0].length_mm;
  const Eigen::JacobiSVD<Eigen::Matrix<double, 6, 6>> svd(scaled);
  if (!(svd.singularValues()[5] > 1e-6 * svd.singularValues()[0]))
    return fail(ErrorCode::failed_precondition, reasons::kRankDeficient,
                "at pose zero the six struts leave a motion of the platform free: their lines are "
                "not independent");
  return made;
}

Result<std::array<double, kStruts>> SixStruts::motors(const SixPose& pose) const {
  const Eigen::Matrix3d rotation = rotation_from(pose.rotation_rad);
  std::array<double, kStruts> q{};
  for (std::size_t i = 0; i < kStruts; ++i) {
    const auto& strut = struts_[i];
    const Eigen::Vector3d d = pose.position_mm + rotation * strut.platform_mm - strut.base_mm;
    const double along = strut.direction.dot(d);
    // The part of d across the carriage's line, without the difference of two large squares.
    const double across2 = (d - along * strut.direction).squaredNorm();
    const double under = strut.length_mm * strut.length_mm - across2;
    if (!(under >= 0))
      return fail(ErrorCode::out_of_range, reasons::kNoPose,
                  "strut " + std::to_string(i + 1) + " of " + digits_text(strut.length_mm, 6) +
                      " mm does not reach the platform, which is " +
                      digits_text(std::sqrt(across2), 6) + " mm from its carriage's line");
    q[i] = along - std::sqrt(under);
  }
  return q;
}

Result<Eigen::Matrix<double, 6, 6>> SixStruts::jacobian(const SixPose& pose) const {
  DRIFTWISE_TRY(const auto q, motors(pose));
  const Eigen::Matrix3d rotation = rotation_from(pose.rotation_rad);
  Eigen::Matrix<double, 6, 6> slopes;
  for (std::size_t i = 0; i < kStruts; ++i) {
    const auto& strut = struts_[i];
    const Eigen::Vector3d arm = rotation * strut.platform_mm;
    const Eigen::Vector3d along =
        pose.position_mm + arm - strut.base_mm - q[i] * strut.direction;  // of length L
    const double push = along.dot(strut.direction);
    slopes.block<1, 3>(static_cast<Eigen::Index>(i), 0) = along.transpose() / push;
    slopes.block<1, 3>(static_cast<Eigen::Index>(i), 3) = arm.cross(along).transpose() / push;
  }
  return slopes;
}

Result<SixPose> SixStruts::pose(const std::array<double, kStruts>& q_mm,
                                const SixPose& guess) const {
  constexpr int kMostSteps = 50;
  constexpr double kClose_mm = 1e-11;
  SixPose at = guess;
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> wanted(q_mm.data());
  for (int step = 0; step < kMostSteps; ++step) {
    DRIFTWISE_TRY(const auto now, motors(at));
    const Eigen::Matrix<double, 6, 1> left =
        wanted - Eigen::Map<const Eigen::Matrix<double, 6, 1>>(now.data());
    if (left.cwiseAbs().maxCoeff() < kClose_mm) return at;
    DRIFTWISE_TRY(const auto slopes, jacobian(at));
    const Eigen::Matrix<double, 6, 1> move = slopes.partialPivLu().solve(left);
    if (!move.allFinite()) break;
    at.position_mm += move.head<3>();
    at.rotation_rad = vector_from(rotation_from(move.tail<3>()) * rotation_from(at.rotation_rad));
  }
  return fail(ErrorCode::out_of_range, reasons::kNoPose,
              "no pose was found at which the six struts meet: the motor coordinates belong to "
              "none near the guess");
}

std::array<Strut, kStruts> orthogonal_struts(double length_mm, double reach_mm, double spacing_mm) {
  std::array<Strut, kStruts> struts;
  for (std::size_t pair = 0; pair < 3; ++pair) {
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(pair)),
                          apart = Eigen::Vector3d::Unit(static_cast<Eigen::Index>((pair + 1) % 3));
    for (std::size_t side = 0; side < 2; ++side) {
      auto& strut = struts[2 * pair + side];
      strut.platform_mm = -reach_mm * along + (side == 0 ? -0.5 : 0.5) * spacing_mm * apart;
      strut.direction = along;
      strut.length_mm = length_mm;
      strut.base_mm = strut.platform_mm - length_mm * along;
    }
  }
  return struts;
}

}  // namespace driftwise::kinematics
