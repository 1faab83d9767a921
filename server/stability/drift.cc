#include "server/stability/drift.h"

#include <Eigen/Dense>
#include <cmath>

#include "server/calibration/noise/serial_noise.h"

namespace driftwise::stability {

std::optional<Drift> drift_of(std::span<const double> time_s, std::span<const double> values) {
  constexpr std::size_t kFewest = 8;
  const std::size_t count = values.size();
  if (count < kFewest || time_s.size() != count) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(count);
  const double n = static_cast<double>(count);
  double middle_s = 0;
  for (const double time : time_s) middle_s += time / n;
  // Orthonormal: the mean, and time about its middle.
  Eigen::MatrixXd columns(rows, 2);
  Eigen::VectorXd y(rows);
  double spread = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = time_s[static_cast<std::size_t>(i)] - middle_s;
    columns(i, 0) = 1 / std::sqrt(n);
    columns(i, 1) = t;
    spread += t * t;
    y(i) = values[static_cast<std::size_t>(i)];
  }
  if (!(spread > 0)) return std::nullopt;
  const double length_s = std::sqrt(spread);
  columns.col(1) /= length_s;
  const double offset = y(0);
  y.array() -= offset;
  const Eigen::Vector2d coefficients = columns.transpose() * y;
  const Eigen::VectorXd residuals = y - columns * coefficients;
  Drift drift;
  drift.mean = offset + coefficients(0) / std::sqrt(n);
  drift.rate_per_h = coefficients(1) / length_s * 3600;
  drift.noise = std::sqrt(residuals.squaredNorm() / (n - 2));
  if (drift.noise > 0) {
    const auto noise = calibration::serial_noise(columns, residuals);
    const Eigen::MatrixXd gram = calibration::correlated_gram(columns, noise);
    drift.u_mean = std::sqrt(noise.variance * gram(0, 0) / n);
    drift.u_rate_per_h = std::sqrt(noise.variance * gram(1, 1)) / length_s * 3600;
  }
  return drift;
}

Samples block_means(const Samples& series, double block_s) {
  Samples means;
  std::size_t i = 0;
  while (i < series.values.size()) {
    const double block = std::floor((series.time_s[i] - series.time_s.front()) / block_s);
    double time = 0, sum = 0, count = 0;
    for (; i < series.values.size() &&
           std::floor((series.time_s[i] - series.time_s.front()) / block_s) == block;
         ++i) {
      time += series.time_s[i];
      sum += series.values[i];
      ++count;
    }
    means.time_s.push_back(time / count);
    means.values.push_back(sum / count);
  }
  return means;
}

}  // namespace driftwise::stability
