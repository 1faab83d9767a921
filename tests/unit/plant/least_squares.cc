#include "tests/unit/plant/least_squares.h"

#include <algorithm>
#include <cmath>

namespace driftwise::testing_support {
namespace {

constexpr double kNmPerMm = 1e6;

double u90(const std::vector<double>& errors_nm) {
  double mean = 0, square = 0;
  for (const double e : errors_nm) mean += e / static_cast<double>(errors_nm.size());
  for (const double e : errors_nm) square += (e - mean) * (e - mean);
  return 1.645 * std::sqrt(square / static_cast<double>(errors_nm.size() - 1));
}

double p90(std::vector<double> errors_nm) {
  for (double& e : errors_nm) e = std::abs(e);
  const auto place =
      errors_nm.begin() + static_cast<long>(0.9 * static_cast<double>(errors_nm.size()));
  std::nth_element(errors_nm.begin(), place, errors_nm.end());
  return *place;
}

}  // namespace

FitFigures fit_campaign(const std::vector<CampaignRow>& rows, const Columns& columns,
                        const Choice& fitted) {
  std::vector<CampaignRow> chosen;
  for (const auto& row : rows) {
    if (fitted(row)) chosen.push_back(row);
  }
  const auto n = static_cast<Eigen::Index>(chosen.size());
  const auto width = static_cast<Eigen::Index>(columns(rows.front()).size());
  Eigen::MatrixXd design(n, width);
  Eigen::VectorXd q_nm(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto values = columns(chosen[static_cast<std::size_t>(i)]);
    for (Eigen::Index j = 0; j < width; ++j) design(i, j) = values[static_cast<std::size_t>(j)];
    q_nm(i) = chosen[static_cast<std::size_t>(i)].q1_mm * kNmPerMm;
  }
  const Eigen::RowVectorXd centre = design.colwise().mean();
  design.rowwise() -= centre;
  Eigen::RowVectorXd scale = design.colwise().norm() / std::sqrt(static_cast<double>(n));
  for (Eigen::Index j = 0; j < width; ++j) design.col(j) /= scale(j);
  const double q_mean = q_nm.mean();
  const Eigen::VectorXd centred_q = q_nm.array() - q_mean;
  const Eigen::VectorXd solution = design.colPivHouseholderQr().solve(centred_q);

  const auto error_nm = [&](const CampaignRow& row) {
    const auto values = columns(row);
    double predicted = q_mean;
    for (Eigen::Index j = 0; j < width; ++j) {
      predicted += solution(j) * (values[static_cast<std::size_t>(j)] - centre(j)) / scale(j);
    }
    return row.q1_mm * kNmPerMm - predicted;
  };
  std::vector<double> validation, calibration;
  for (const auto& row : rows) {
    if (!row.calibration) validation.push_back(error_nm(row));
  }
  for (const auto& row : chosen) calibration.push_back(error_nm(row));
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
