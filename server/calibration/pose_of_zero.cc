#include "server/calibration/pose_of_zero.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr int kZeroIterations = 8;
constexpr double kSlopeStep = 1e-4;   // of an axis' fitted range
constexpr double kConverged = 1e-10;  // of it

}  // namespace

Eigen::VectorXd pose_of_zero(const std::vector<double>& ranges,
                             const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& left) {
  const auto n = static_cast<Index>(ranges.size());
  const Eigen::VectorXd nowhere = Eigen::VectorXd::Zero(n);
  if (n == 0 || std::ranges::any_of(ranges, [](double range) { return !(range > 0); }))
    return nowhere;
  const Eigen::Map<const Eigen::ArrayXd> range(ranges.data(), n);
  Eigen::VectorXd shift = nowhere;
  for (int turn = 0; turn < kZeroIterations; ++turn) {
    Eigen::MatrixXd slopes(n, n);
    for (Index j = 0; j < n; ++j) {
      const double step = kSlopeStep * range[j];
      Eigen::VectorXd below = shift, above = shift;
      below[j] -= step;
      above[j] += step;
      slopes.col(j) = (left(below) - left(above)) / (2 * step);
    }
    const Eigen::VectorXd by = slopes.partialPivLu().solve(left(shift));
    shift += by;
    if (!by.allFinite() || !((shift.array().abs() / range).maxCoeff() < kFarthestZero))
      return nowhere;
    if ((by.array().abs() / range).maxCoeff() < kConverged) return shift;
  }
  return nowhere;
}

}  // namespace driftwise::calibration
