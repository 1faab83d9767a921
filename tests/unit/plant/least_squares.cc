#include "tests/unit/plant/least_squares.h"

#include <algorithm>
#include <cmath>

namespace driftwise::testing_support {
namespace {

constexpr double kNmPerMm = 1e6;

double p90(std::vector<double> errors_nm) {
  for (double& e : errors_nm) e = std::abs(e);
  const auto place =
      errors_nm.begin() + static_cast<long>(0.9 * static_cast<double>(errors_nm.size()));
  std::nth_element(errors_nm.begin(), place, errors_nm.end());
  return *place;
}

}  // namespace

double u90(const std::vector<double>& errors) {
  double mean = 0, square = 0;
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  for (const double e : errors) square += (e - mean) * (e - mean);
  return 1.645 * std::sqrt(square / static_cast<double>(errors.size() - 1));
}

LeastSquares::LeastSquares(const std::vector<std::vector<double>>& rows,
                           const std::vector<double>& q) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  const auto width = static_cast<Eigen::Index>(rows.front().size());
  Eigen::MatrixXd design(n, width);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& values = rows[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < width; ++j) design(i, j) = values[static_cast<std::size_t>(j)];
  }
  const Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(q.data(), n);
  centre_ = design.colwise().mean();
  design.rowwise() -= centre_;
  scale_ = design.colwise().norm() / std::sqrt(static_cast<double>(n));
  for (Eigen::Index j = 0; j < width; ++j) design.col(j) /= scale_(j);
  mean_ = right.mean();
  const Eigen::VectorXd centred = right.array() - mean_;
  solution_ = design.colPivHouseholderQr().solve(centred);
}

double LeastSquares::predicted(const std::vector<double>& row) const {
  double sum = mean_;
  for (Eigen::Index j = 0; j < solution_.size(); ++j) {
    sum += solution_(j) * (row[static_cast<std::size_t>(j)] - centre_(j)) / scale_(j);
  }
  return sum;
}

FitFigures fit_campaign(const std::vector<CampaignRow>& rows, const Columns& columns,
                        const Choice& fitted) {
  std::vector<std::vector<double>> design;
  std::vector<double> q_nm;
  for (const auto& row : rows) {
    if (!fitted(row)) continue;
    design.push_back(columns(row));
    q_nm.push_back(row.q1_mm * kNmPerMm);
  }
  const LeastSquares fit(design, q_nm);
  std::vector<double> validation, calibration;
  for (const auto& row : rows) {
    const double error_nm = row.q1_mm * kNmPerMm - fit.predicted(columns(row));
    if (!row.calibration) validation.push_back(error_nm);
    if (fitted(row)) calibration.push_back(error_nm);
  }
  return {
      .u90_nm = u90(validation), .p90_nm = p90(validation), .u90_calibration_nm = u90(calibration)};
}

Columns polynomial_and_temperatures(int first_sensor, int last_sensor) {
  return [=](const CampaignRow& row) {
    std::vector<double> values{row.x_mm, row.x_mm * row.x_mm};
    for (int sensor = first_sensor; sensor <= last_sensor; ++sensor) {
      values.push_back(row.t_degc[static_cast<std::size_t>(sensor - 1)]);
    }
    return values;
  };
}

Columns oracle_columns() {
  return [](const CampaignRow& row) {
    return std::vector<double>{row.x_mm, row.x_mm * row.x_mm, row.robot_drift_nm,
                               row.device_drift_nm};
  };
}

}  // namespace driftwise::testing_support
