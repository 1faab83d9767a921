#include "server/diagnosis/rows/spread_over_places.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kClip = 9;      // of a square, in units of its usual size
constexpr double kMostLn = 1.2;  // of the variance, on either side of its middle: sd 1 to 3.3
constexpr Eigen::Index kRowsPerColumn = 15;
constexpr int kSteps = 12;

// Every dataset row: 1, then u and u^2 of each pose coordinate that varies, u from -1 to 1.
Eigen::MatrixXd place_columns(const Problem& problem, Eigen::Index most) {
  const Dataset& data = problem.prepared.conditions();
  std::vector<Eigen::VectorXd> found;
  for (const auto& column : data.columns) {
    if (!is_pose_symbol(column.channel.symbol)) continue;
    double low = INFINITY, high = -INFINITY;
    for (const double value : column.values)
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    if (!(high > low)) continue;
    Eigen::VectorXd u(static_cast<Eigen::Index>(column.values.size()));
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      const double value = column.values[static_cast<std::size_t>(i)];
      u[i] = std::isfinite(value) ? (2 * value - low - high) / (high - low) : 0;
    }
    found.push_back(std::move(u));
  }
  const auto axes = static_cast<Eigen::Index>(found.size());
  const Eigen::Index each = 1 + 2 * axes <= most ? 2 : 1;
  if (axes == 0 || 1 + each * axes > most) return {};
  Eigen::MatrixXd result(static_cast<Eigen::Index>(data.rows), 1 + each * axes);
  result.col(0).setOnes();
  for (Eigen::Index j = 0; j < axes; ++j) {
    const auto& u = found[static_cast<std::size_t>(j)];
    result.col(1 + each * j) = u;
    if (each == 2) result.col(2 + 2 * j) = u.cwiseAbs2();
  }
  return result;
}

// Per block: the mean over the outputs of the squares of what is left, each about 1, clipped.
Eigen::VectorXd squares(const Ground& ground) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(ground.series().rows());
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const Eigen::VectorXd left =
        ground.space(ground.best_shape(o)).left_over(ground.series().col(o));
    const double sd = robust_sd({left.data(), left.data() + left.size()});
    if (!(sd > 0)) return {};
    sum += (left / sd).cwiseAbs2().cwiseMin(kClip);
  }
  return sum / static_cast<double>(ground.outputs());
}

}  // namespace

std::optional<Eigen::VectorXd> spread_over_places(const Problem& problem, const Ground& ground) {
  const Eigen::VectorXd y = squares(ground);
  if (y.size() == 0) return std::nullopt;
  const Eigen::MatrixXd all = place_columns(problem, y.size() / kRowsPerColumn);
  if (all.cols() < 2) return std::nullopt;
  const Eigen::MatrixXd z = problem.learned(all);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(z);
  if (qr.rank() < z.cols()) return std::nullopt;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(z.cols());
  b[0] = std::log(std::max(y.mean(), 1e-12));
  Eigen::VectorXd miss(y.size());
  for (int step = 0; step < kSteps; ++step) {  // likelihood of gamma-distributed squares
    miss = y.cwiseQuotient((z * b).array().exp().matrix()).array() - 1;
    b += qr.solve(miss).cwiseMax(-1.0).cwiseMin(1.0);
  }
  if (!b.allFinite()) return std::nullopt;
  const Eigen::Index k = z.cols() - 1;
  const Eigen::LLT<Eigen::MatrixXd> information(z.transpose() * z);
  const Eigen::MatrixXd scores = miss.asDiagonal() * z;
  const Eigen::MatrixXd half = information.solve(scores.transpose());
  const Eigen::MatrixXd covariance = half * half.transpose();
  const Eigen::VectorXd slopes = b.tail(k);
  const double wald = slopes.dot(covariance.bottomRightCorner(k, k).llt().solve(slopes));
  const auto dof = static_cast<double>(k);
  if (!(wald > dof + 4 * std::sqrt(2 * dof) + 6)) return std::nullopt;
  const Eigen::VectorXd ln = all.rightCols(k) * slopes;
  const double middle = (z.rightCols(k) * slopes).mean();
  Eigen::VectorXd variance = (ln.array() - middle).max(-kMostLn).min(kMostLn).exp().matrix();
  variance /= problem.learned(variance).mean();
  return variance.cwiseSqrt();
}

}  // namespace driftwise::diagnosis
