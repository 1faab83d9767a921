#include "server/diagnosis/rows/smoothing.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr std::array<double, 6> kWidths = {0.5, 1, 2, 4, 8, 16};  // typical steps
constexpr double kKernelReach = 3;         // standard deviations of the kernel
constexpr std::size_t kMostJudged = 4000;  // values that the choice of width looks at
constexpr Eigen::Index kShapes = 3;        // that the thermometers have in common
constexpr Eigen::Index kRowsPerShape = 10;
constexpr double kClearlyLess = 5;  // standard deviations

// Twice a log-likelihood that k free amplitudes gain by chance hardly ever: chi-squared with k
// degrees of freedom, and `more` beyond four standard deviations of it.
double by_chance(double k, double more) { return k + 4 * std::sqrt(2 * k) + more; }

struct Local {
  double with = 0, without = 0;  // the line's value at the point, fitted with it and without
};

// present: the rows that have a value.
Local line_at(std::span<const double> time_s, std::span<const double> values,
              const std::vector<std::size_t>& present, std::size_t at, double width_s) {
  const double t0 = time_s[present[at]];
  double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
  const auto add = [&](std::size_t i) {
    const double dt = time_s[present[i]] - t0;
    if (std::abs(dt) > kKernelReach * width_s) return false;
    const double w = std::exp(-0.5 * dt * dt / (width_s * width_s));
    const double y = values[present[i]] - values[present[at]];  // small numbers
    s0 += w, s1 += w * dt, s2 += w * dt * dt, y0 += w * y, y1 += w * dt * y;
    return true;
  };
  for (std::size_t i = at + 1; i < present.size() && add(i); ++i) continue;
  for (std::size_t i = at; i > 0 && add(i - 1); --i) continue;
  const auto solve = [&](double own) {
    const double n = s0 + own;
    const double determinant = n * s2 - s1 * s1;
    if (!(n > 0)) return 0.0;
    return determinant > 1e-12 * n * s2 ? (s2 * y0 - s1 * y1) / determinant : y0 / n;
  };
  return {values[present[at]] + solve(1), values[present[at]] + solve(0)};
}

}  // namespace

std::vector<double> smoothed(std::span<const double> time_s, std::span<const double> values) {
  std::vector<double> result(values.begin(), values.end());
  std::vector<std::size_t> present;
  std::vector<double> steps;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (!present.empty()) steps.push_back(time_s[i] - time_s[present.back()]);
    present.push_back(i);
  }
  if (present.size() < 16) return result;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double step_s = *middle;
  if (!(step_s > 0)) return result;
  double best = INFINITY, chosen_s = 0;
  const std::size_t every = std::max<std::size_t>(1, present.size() / kMostJudged);
  for (const double width : kWidths) {
    double squares = 0;
    for (std::size_t i = 0; i < present.size(); i += every) {
      const double miss =
          line_at(time_s, values, present, i, width * step_s).without - values[present[i]];
      squares += miss * miss;
    }
    if (squares >= best) continue;
    best = squares;
    chosen_s = width * step_s;
  }
  if (!(best > 0)) return result;
  for (std::size_t i = 0; i < present.size(); ++i)
    result[present[i]] = line_at(time_s, values, present, i, chosen_s).with;
  return result;
}

namespace {

// Rows x shapes: what these columns (unit variance, missing 0) have in common, one row before, at
// the row and one row after: thermometers follow a cycle at different phases.
Eigen::MatrixXd common_shapes(const Eigen::MatrixXd& columns) {
  const Eigen::Index n = columns.rows(), count = std::min(kShapes, columns.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(columns.transpose() * columns);
  const Eigen::MatrixXd shapes = columns * own.eigenvectors().rightCols(count);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, 3 * count);
  result.leftCols(count) = shapes;
  result.middleCols(count, count).bottomRows(n - 1) = shapes.topRows(n - 1);
  result.rightCols(count).topRows(n - 1) = shapes.bottomRows(n - 1);
  return result;
}

}  // namespace

std::vector<std::vector<double>> smoothed_together(std::span<const double> time_s,
                                                   const std::vector<std::vector<double>>& values) {
  std::vector<std::vector<double>> result;
  for (const auto& one : values) result.push_back(smoothed(time_s, one));
  const auto n = static_cast<Eigen::Index>(time_s.size());
  Eigen::MatrixXd taken = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(values.size()));
  Eigen::VectorXd sd = Eigen::VectorXd::Zero(taken.cols());
  std::vector<Eigen::Index> changed;
  for (Eigen::Index j = 0; j < taken.cols(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    double squares = 0, count = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double gone =
          values[at][static_cast<std::size_t>(i)] - result[at][static_cast<std::size_t>(i)];
      if (!std::isfinite(gone)) continue;
      taken(i, j) = gone;
      squares += gone * gone, count += 1;
    }
    sd[j] = count > 0 ? std::sqrt(squares / count) : 0;
    if (!(sd[j] > 0)) continue;
    taken.col(j) /= sd[j];
    changed.push_back(j);
  }
  for (const Eigen::Index j : changed) {
    std::vector<Eigen::Index> others;
    for (const Eigen::Index k : changed)
      if (k != j) others.push_back(k);
    if (others.empty()) continue;
    const Eigen::MatrixXd shapes = common_shapes(taken(Eigen::all, others));
    if (n < kRowsPerShape * shapes.cols()) continue;
    const Eigen::VectorXd own = taken.col(j);
    const Eigen::VectorXd foretold = shapes * shapes.colPivHouseholderQr().solve(own);
    const double known = 1 - (own - foretold).squaredNorm() / own.squaredNorm();
    const auto k = static_cast<double>(shapes.cols());
    // Nothing where the others know nothing.
    if (!(known > 0) || known >= 1 ||
        -static_cast<double>(n) * std::log1p(-known) < by_chance(k, 6))
      continue;
    for (Eigen::Index i = 0; i < n; ++i)
      result[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] +=
          sd[j] * (foretold[i] + known * (own[i] - foretold[i]));
  }
  return result;
}

double share_followed(const Eigen::MatrixXd& base, const Eigen::MatrixXd& outputs,
                      const Eigen::VectorXd& smooth, const Eigen::VectorXd& taken,
                      const Eigen::MatrixXd& shapes) {
  const Eigen::Index n = base.rows(), count = shapes.cols(), before = base.cols() + count;
  if (n < before + kRowsPerShape * count || !(taken.norm() > 0)) return 0;
  Eigen::MatrixXd x(n, before + count);
  const Eigen::VectorXd level = (smooth.array() - smooth.mean()).matrix();
  x << base, level.asDiagonal() * shapes, taken.asDiagonal() * shapes;
  const Eigen::RowVectorXd scale = x.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  x = x * scale.asDiagonal();
  const auto left_by = [&](const Eigen::MatrixXd& columns) {
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    qr.setThreshold(1e-9);
    return Eigen::VectorXd((outputs - columns * qr.solve(outputs)).colwise().squaredNorm());
  };
  const Eigen::VectorXd without = left_by(x.leftCols(before)), with = left_by(x);
  double gain = 0;
  for (Eigen::Index o = 0; o < outputs.cols(); ++o)
    if (without[o] > 0)
      gain += static_cast<double>(n) * std::log(without[o] / std::max(with[o], 1e-12 * without[o]));
  if (!(gain > by_chance(static_cast<double>(count * outputs.cols()), 10))) return 0;
  // Of the output and shape that follow most: both coefficients, the second one's error.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(x);
  const Eigen::MatrixXd b = scale.transpose().asDiagonal() * Eigen::MatrixXd(qr.solve(outputs));
  const Eigen::MatrixXd r = qr.matrixQR().topRows(x.cols());
  const Eigen::MatrixXd inverse =
      r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(x.cols(), x.cols()));
  double share = 1, most = 0;
  for (Eigen::Index o = 0; o < outputs.cols(); ++o) {
    const double sd = std::sqrt(with[o] / static_cast<double>(n - x.cols()));
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index fast = before + k, slow = base.cols() + k;
      const auto error_of = [&](Eigen::Index at) {
        return sd * scale[at] * inverse.row(at).norm();
      };
      const double size = std::abs(b(fast, o)) / error_of(fast);
      if (!(size > most)) continue;
      most = size;
      // A part only where it is clearly one: a ratio of uncertain numbers would be an error of its
      // own.
      const bool is_part = std::abs(b(slow, o) - b(fast, o)) >
                           kClearlyLess * std::hypot(error_of(slow), error_of(fast));
      share = is_part ? std::clamp(b(fast, o) / b(slow, o), 0.0, 1.0) : 1;
    }
  }
  return share;
}

}  // namespace driftwise::diagnosis
