#include "server/diagnosis/pose_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::array<double, 4> kShares = {1, 0.75, 0.5, 0.25};  // of the variance: the pose's
constexpr double kFreedom = 5;               // of the Student law that spreads are compared under
constexpr int kScaleRounds = 30;             // of the fit of its scale
constexpr int kSpreadRounds = 4;             // of fit and spread in turn
constexpr double kNearlyOne = 1.3;           // ratio that changes no answer
constexpr double kFarthest = 1e3;            // spread over the middle one: of a singular pose
constexpr Eigen::Index kMostUnknowns = 600;  // of the fit of all outputs together
constexpr double kRidge = 1e-12;             // of the normal equations' diagonal

// 2 ln L of what is left, with this variance of each row, up to a constant; the scale is fitted.
double student_two_ln(const Eigen::ArrayXd& squares, const Eigen::ArrayXd& variance) {
  const Eigen::ArrayXd relative = squares / variance;
  double scale = std::max(relative.mean(), 1e-300);
  for (int round = 0; round < kScaleRounds; ++round)
    scale = std::max(((kFreedom + 1) * relative / (kFreedom + relative / scale)).mean(), 1e-300);
  const auto n = static_cast<double>(squares.size());
  return -variance.log().sum() - n * std::log(scale) -
         (kFreedom + 1) * (1 + relative / (kFreedom * scale)).log().sum();
}

// Residuals of the rows that learn, and how the motors follow the pose there.
struct Learned {
  std::vector<Eigen::MatrixXd> slopes;   // per row: outputs x coordinates
  std::vector<Eigen::MatrixXd> inverse;  // per row; of a singular pose: not finite
  Eigen::MatrixXd columns, left;         // of the baseline, lengths 1; rows x outputs
};

// Robust standard deviation of each pose coordinate's noise.
Eigen::VectorXd pose_spread(const Learned& at) {
  std::vector<std::vector<double>> off(static_cast<std::size_t>(at.left.cols()));
  for (std::size_t i = 0; i < at.inverse.size(); ++i) {
    const Eigen::VectorXd pose =
        at.inverse[i] * at.left.row(static_cast<Eigen::Index>(i)).transpose();
    if (!pose.allFinite()) continue;
    for (Eigen::Index k = 0; k < pose.size(); ++k)
      off[static_cast<std::size_t>(k)].push_back(pose[k]);
  }
  Eigen::VectorXd spread(at.left.cols());
  for (std::size_t k = 0; k < off.size(); ++k)
    spread[static_cast<Eigen::Index>(k)] = off[k].empty() ? 0 : robust_sd(std::move(off[k]));
  return spread;
}

// Residuals of generalised least squares of all motors together, with this spread of the pose. A
// noise of tilts that is a thousand times that of lengths is in every motor, and motor by motor the
// fit's own error hides the lengths'.
Eigen::MatrixXd left_by_all(const Learned& at, const Eigen::VectorXd& spread) {
  const Eigen::Index n = at.columns.rows(), width = at.columns.cols(), outputs = at.left.cols();
  std::vector<Eigen::MatrixXd> weight;  // per row: inverse of the motors' covariance
  for (const auto& inverse : at.inverse) {
    const Eigen::MatrixXd scaled = spread.cwiseInverse().asDiagonal() * inverse;
    weight.emplace_back(scaled.transpose() * scaled);
    if (!weight.back().allFinite()) weight.back().setZero();
  }
  Eigen::MatrixXd normal(outputs * width, outputs * width);
  Eigen::VectorXd along = Eigen::VectorXd::Zero(outputs * width), of_row(n);
  for (Eigen::Index a = 0; a < outputs; ++a)
    for (Eigen::Index b = 0; b < outputs; ++b) {
      for (Eigen::Index i = 0; i < n; ++i) of_row[i] = weight[static_cast<std::size_t>(i)](a, b);
      along.segment(a * width, width) +=
          at.columns.transpose() * of_row.cwiseProduct(at.left.col(b));
      if (b > a) continue;
      normal.block(a * width, b * width, width, width).noalias() =
          at.columns.transpose() * of_row.asDiagonal() * at.columns;
    }
  normal.diagonal() *= 1 + kRidge;
  const Eigen::VectorXd b = normal.selfadjointView<Eigen::Lower>().ldlt().solve(along);
  if (!b.allFinite()) return at.left;
  return at.left - at.columns * b.reshaped(width, outputs);
}

Learned learned_of(const Problem& problem) {
  Learned result;
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  result.columns = rows_of(problem.base_columns, problem.learn);
  result.columns =
      result.columns * result.columns.colwise().norm().cwiseMax(1e-300).cwiseInverse().asDiagonal();
  result.left.resize(result.columns.rows(), outputs);
  for (Eigen::Index o = 0; o < outputs; ++o)
    result.left.col(o) = rows_of(
        residuals(problem, problem.outputs[static_cast<std::size_t>(o)], problem.base_columns),
        problem.learn);
  for (const std::size_t row : problem.learn) {
    result.slopes.push_back(problem.slopes[row]);
    result.inverse.emplace_back(problem.slopes[row].partialPivLu().inverse());
  }
  return result;
}

}  // namespace

std::optional<PoseNoise> pose_noise(const Problem& problem) {
  if (problem.slopes.empty()) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(problem.slopes.size());
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  Learned at = learned_of(problem);
  const Eigen::ArrayXXd squares = at.left.array().square();
  Eigen::VectorXd spread = pose_spread(at);
  for (int round = 0; round < kSpreadRounds; ++round) {
    if (!(spread.minCoeff() > 0) || !spread.allFinite()) return std::nullopt;
    if (at.columns.cols() * outputs > kMostUnknowns) break;
    const Eigen::MatrixXd motor_by_motor = at.left;
    at.left = left_by_all(at, spread);
    spread = pose_spread(at);
    at.left = motor_by_motor;
  }
  Eigen::MatrixXd variance(rows, outputs);  // of the pose's noise in each output
  for (Eigen::Index row = 0; row < rows; ++row)
    variance.row(row) = (problem.slopes[static_cast<std::size_t>(row)] * spread.asDiagonal())
                            .rowwise()
                            .squaredNorm();
  Eigen::VectorXd middle(outputs);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const Eigen::VectorXd learned = rows_of(variance.col(o), problem.learn);
    middle[o] = median({learned.data(), learned.data() + learned.size()});
    if (!(middle[o] > 0)) return std::nullopt;
    for (double& one : variance.col(o))
      one = std::isfinite(one)
                ? std::clamp(one / middle[o], 1 / (kFarthest * kFarthest), kFarthest * kFarthest)
                : 1;
  }
  const Eigen::MatrixXd of_learn = rows_of(variance, problem.learn);
  const auto by_share = [&](double share) {
    double sum = 0;
    for (Eigen::Index o = 0; o < outputs; ++o)
      sum += student_two_ln(squares.col(o), 1 - share + share * of_learn.col(o).array());
    return sum;
  };
  double likeliest = 0, highest = by_share(0);
  for (const double share : kShares)
    if (const double one = by_share(share); one > highest) highest = one, likeliest = share;
  if (likeliest == 0) return std::nullopt;
  variance = (1 - likeliest + likeliest * variance.array()).matrix();
  PoseNoise result;
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const Eigen::VectorXd learned = rows_of(variance.col(o), problem.learn);
    variance.col(o) /= learned.mean();
    const double ratio = std::sqrt(learned.maxCoeff() / learned.minCoeff());
    if (ratio <= result.ratio) continue;
    result.ratio = ratio;
    result.output = static_cast<std::size_t>(o);
  }
  if (result.ratio < kNearlyOne) return std::nullopt;
  result.of_row = variance.rowwise().mean().cwiseSqrt();
  result.own = result.of_row.cwiseInverse().asDiagonal() * variance.cwiseSqrt();
  const Eigen::RowVectorXd mean_squares =
      rows_of(result.own.cwiseAbs2(), problem.learn).colwise().mean();
  result.own = result.own * mean_squares.cwiseSqrt().cwiseInverse().asDiagonal();
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Eigen::MatrixXd of_pose = middle.cwiseSqrt().cwiseInverse().asDiagonal() *
                                    problem.slopes[static_cast<std::size_t>(row)] *
                                    spread.asDiagonal();
    Eigen::MatrixXd covariance = likeliest * (of_pose * of_pose.transpose());
    covariance.diagonal().array() += 1 - likeliest + kRidge * covariance.trace();
    Eigen::MatrixXd mixing = covariance.llt().matrixL();
    for (Eigen::Index o = 0; o < outputs; ++o) {
      const double length = mixing.row(o).norm();
      if (length > 0 && std::isfinite(length))
        mixing.row(o) *= result.own(row, o) / length;
      else
        mixing.row(o) = result.own(row, o) * Eigen::RowVectorXd::Unit(outputs, o);
    }
    result.mixing.push_back(std::move(mixing));
  }
  return result;
}

}  // namespace driftwise::diagnosis
