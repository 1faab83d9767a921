#include "server/diagnosis/answer/shares.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace driftwise::diagnosis {

double marginal_share(const std::vector<double>& variable, const std::vector<double>& y) {
  std::vector<std::size_t> rows;
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (!std::isfinite(y[i]) || !std::isfinite(variable[i])) continue;
    rows.push_back(i);
    low = std::min(low, variable[i]);
    high = std::max(high, variable[i]);
  }
  if (rows.size() < 4 || !(high > low)) return 0;
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 3);
  Eigen::VectorXd values(columns.rows());
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const std::size_t row = rows[static_cast<std::size_t>(i)];
    const double u = (2 * variable[row] - low - high) /
                     (high - low);  // scaled: v^2 beside v stays well conditioned
    columns.row(i) << 1, u, u * u;
    values[i] = y[row];
  }
  const double total = (values.array() - values.mean()).square().sum();
  if (total <= 0) return 0;
  const Eigen::VectorXd rest = values - columns * columns.colPivHouseholderQr().solve(values);
  return std::clamp(1 - rest.squaredNorm() / total, 0.0, 1.0);
}

}  // namespace driftwise::diagnosis
