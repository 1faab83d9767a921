#include "server/kinematics/rigid_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "server/core/reasons.h"

namespace driftwise::kinematics {

Result<RigidFit> fit_rigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  if (from.cols() < 3 || from.cols() != to.cols())
    return fail(ErrorCode::failed_precondition, reasons::kTooFewPoints,
                "a rigid fit needs at least three points measured in both frames, found " +
                    std::to_string(std::min(from.cols(), to.cols())));
  const Eigen::Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  const Eigen::Matrix3Xd centred = from.colwise() - from_mean;
  const Eigen::Matrix3d product = (to.colwise() - to_mean) * centred.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 1e-10 * svd.singularValues()[0]))
    return fail(ErrorCode::failed_precondition, reasons::kPointsOnALine,
                "the points lie on a line: how the robot stands in the measuring frame cannot be "
                "told from them");
  Eigen::Vector3d signs(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs[2] = -1;
  RigidFit fit;
  fit.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  fit.translation = to_mean - fit.rotation * from_mean;
  const Eigen::Matrix3Xd left = to - ((fit.rotation * from).colwise() + fit.translation);
  fit.rms = std::sqrt(left.squaredNorm() / static_cast<double>(from.cols()));
  return fit;
}

}  // namespace driftwise::kinematics
