#include "server/diagnosis/rows/spread_over_places.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kClip = 9;      // of a square, in units of its usual size
constexpr double kMostLn = 1.2;  // of the variance, on either side of its middle: sd 1 to 3.3
constexpr Eigen::Index kRowsPerColumn = 15;
constexpr int kSteps = 12;
constexpr double kNotNew = 0.05;  // of a column's length: places that shift a little are the same
constexpr double kDay_s = 86400, kPartOfADay = 0.5;

// Every dataset row: 1, then u of each pose coordinate that varies (-1 to 1), then its squares.
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
    result.col(1 + j) = u;
    if (each == 2) result.col(1 + axes + j) = u.cwiseAbs2();
  }
  return result;
}

// Every dataset row: 1, then u and u^2 of the time (-1 to 1), and the cosine and sine of the day's
// cycle where the rows that learn cover a good part of one.
Eigen::MatrixXd time_columns(const Problem& problem, Eigen::Index most) {
  const auto& time_s = problem.data().time_s;
  if (time_s.empty() || most < 3) return {};
  const auto n = static_cast<Eigen::Index>(time_s.size());
  const double first_s = time_s.front(), length_s = time_s.back() - first_s;
  if (!(length_s > 0)) return {};
  const bool day = length_s > kPartOfADay * kDay_s && most >= 5;
  Eigen::MatrixXd result = Eigen::MatrixXd::Ones(n, day ? 5 : 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double since_s = time_s[static_cast<std::size_t>(i)] - first_s;
    const double u = 2 * since_s / length_s - 1;
    result(i, 1) = u;
    result(i, 2) = u * u;
    if (!day) continue;
    result(i, 3) = std::cos(2 * std::numbers::pi * since_s / kDay_s);
    result(i, 4) = std::sin(2 * std::numbers::pi * since_s / kDay_s);
  }
  return result;
}

// The columns that are no combinations of those before them, on the rows that learn: six places
// determine no polynomial of second degree in three coordinates, and still have a spread each.
Eigen::MatrixXd determined(const Problem& problem, const Eigen::MatrixXd& all) {
  const Eigen::MatrixXd learned = problem.learned(all);
  Eigen::MatrixXd basis(learned.rows(), learned.cols());
  std::vector<Eigen::Index> kept;
  for (Eigen::Index j = 0; j < learned.cols(); ++j) {
    Eigen::VectorXd rest = learned.col(j);
    const auto known = basis.leftCols(static_cast<Eigen::Index>(kept.size()));
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= known * (known.transpose() * rest).eval();
    if (!(rest.norm() > kNotNew * learned.col(j).norm())) continue;
    basis.col(static_cast<Eigen::Index>(kept.size())) = rest.normalized();
    kept.push_back(j);
  }
  return all(Eigen::all, kept);
}

// Per block and output: the squares of what is left, each about 1, clipped.
Eigen::MatrixXd squares(const Ground& ground) {
  Eigen::MatrixXd result(ground.series().rows(), ground.outputs());
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const Eigen::VectorXd left =
        ground.space(ground.best_shape(o), o).left_over(ground.series().col(o));
    const double sd = robust_sd({left.data(), left.data() + left.size()});
    if (!(sd > 0)) return {};
    result.col(o) = (left / sd).cwiseAbs2().cwiseMin(kClip);
  }
  return result;
}

struct OneSpread {
  Eigen::VectorXd sd;
  double gain = 0;
};

// all: every dataset row, the first column 1. y: squares, the mean of so many outputs'.
std::optional<OneSpread> fitted_to(const Problem& problem, const Eigen::VectorXd& y, double outputs,
                                   const Eigen::MatrixXd& all) {
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
  OneSpread result;
  // Of 2 ln L for normal rows, and less where the squares scatter more than those of normal rows
  // do: a mean of `outputs` of them has the variance 2 / outputs.
  const Eigen::ArrayXd relative = problem.learned(variance).array();
  const double level = (y.array() / relative).mean();
  const double scatter = (y.array() / (relative * level) - 1).square().mean();
  result.gain =
      outputs *
      (static_cast<double>(y.size()) * std::log(y.mean() / level) - relative.log().sum()) /
      std::max(outputs * scatter / 2, 1.0);
  result.sd = variance.cwiseSqrt();
  return result;
}

std::optional<Spread> fitted_spread(const Problem& problem, const Ground& ground,
                                    const Eigen::MatrixXd& all) {
  const Eigen::MatrixXd of_output = squares(ground);
  if (of_output.size() == 0 || all.cols() < 2) return std::nullopt;
  const Eigen::Index outputs = of_output.cols();
  Spread own{Eigen::MatrixXd::Ones(all.rows(), outputs), {}, 0};
  for (Eigen::Index o = 0; outputs > 1 && o < outputs; ++o)
    if (const auto one = fitted_to(problem, of_output.col(o), 1, all)) {
      own.sd.col(o) = one->sd;
      own.outputs.push_back(static_cast<std::size_t>(o));
      own.gain += one->gain;
    }
  const auto together =
      fitted_to(problem, of_output.rowwise().mean(), static_cast<double>(outputs), all);
  if (!together || own.gain > together->gain)
    return own.outputs.empty() ? std::nullopt : std::optional(std::move(own));
  Spread shared{together->sd.replicate(1, outputs), {}, together->gain};
  for (Eigen::Index o = 0; o < outputs; ++o) shared.outputs.push_back(static_cast<std::size_t>(o));
  return shared;
}

}  // namespace

std::optional<Spread> spread_over_places(const Problem& problem, const Ground& ground) {
  const Eigen::MatrixXd all = place_columns(problem, ground.series().rows() / kRowsPerColumn);
  if (all.cols() < 2) return std::nullopt;
  return fitted_spread(problem, ground, determined(problem, all));
}

std::optional<Spread> spread_over_time(const Problem& problem, const Ground& ground) {
  const Eigen::MatrixXd all = time_columns(problem, ground.series().rows() / kRowsPerColumn);
  if (all.cols() < 2) return std::nullopt;
  return fitted_spread(problem, ground, determined(problem, all));
}

}  // namespace driftwise::diagnosis
