#include "server/diagnosis/rows/inverted_baseline.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/try.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kShift = 1e-4;       // of a coordinate's range, for derivatives
constexpr double kDetermined = 1e-6;  // of the largest pivot

// Of the baseline on the learning rows; per column of the baseline.
Eigen::MatrixXd coefficients_of(const Problem& problem, const Eigen::MatrixXd& measured) {
  Eigen::MatrixXd learned = rows_of(problem.base_columns, problem.learn);
  const Eigen::RowVectorXd inverse = learned.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  learned = learned * inverse.asDiagonal();
  return inverse.transpose().asDiagonal() *
         learned.colPivHouseholderQr().solve(rows_of(measured, problem.learn)).eval();
}

double range_of(std::span<const double> values) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : values)
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  return high > low ? high - low : 0;
}

}  // namespace

Result<std::map<std::string, std::vector<double>>> inverted_baseline(const Problem& problem) {
  std::map<std::string, std::vector<double>> pose;
  const Dataset& data = problem.data();
  std::vector<std::string> coordinates;
  for (const auto& column : data.columns)
    if (is_coordinate(problem, column.channel) && range_of(column.values) > 0)
      coordinates.push_back(column.channel.symbol);
  const auto m = static_cast<Eigen::Index>(coordinates.size());
  if (m == 0 || coordinates.size() != problem.outputs.size() ||
      !std::ranges::all_of(problem.outputs, [](const ProblemOutput& output) {
        return is_motor_symbol(output.channel.symbol);
      }))
    return pose;
  Eigen::MatrixXd measured(problem.base_columns.rows(), m);
  for (Eigen::Index o = 0; o < m; ++o)
    measured.col(o) = problem.outputs[static_cast<std::size_t>(o)].measured;
  const Eigen::MatrixXd b = coefficients_of(problem, measured);
  const Eigen::MatrixXd left = measured - problem.base_columns * b;
  std::vector<Eigen::MatrixXd> slopes;  // per coordinate: rows x outputs
  for (const auto& symbol : coordinates) {
    const auto now = data.values_of(symbol);
    const double shift = kShift * range_of(now);
    Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(measured.rows(), m);
    for (const double side : {1.0, -1.0}) {
      std::vector<double> shifted(now.begin(), now.end());
      for (double& value : shifted) value += side * shift;
      Prepared there = problem.prepared;
      there.set_coordinate(symbol, shifted);
      DRIFTWISE_TRY(const auto columns, there.columns(problem.base));
      difference += side * (columns * b);
    }
    slopes.push_back(difference / (2 * shift));
    pose.emplace(symbol, std::vector<double>(now.begin(), now.end()));
  }
  Eigen::MatrixXd slope(m, m);
  for (Eigen::Index row = 0; row < measured.rows(); ++row) {
    for (Eigen::Index c = 0; c < m; ++c)
      slope.col(c) = slopes[static_cast<std::size_t>(c)].row(row).transpose();
    if (!slope.allFinite() || !left.row(row).allFinite()) continue;
    Eigen::FullPivLU<Eigen::MatrixXd> lu(slope);
    lu.setThreshold(kDetermined);
    if (!lu.isInvertible()) return std::map<std::string, std::vector<double>>{};
    const Eigen::VectorXd step = lu.solve(left.row(row).transpose());
    for (Eigen::Index c = 0; c < m; ++c)
      pose[coordinates[static_cast<std::size_t>(c)]][static_cast<std::size_t>(row)] += step[c];
  }
  return pose;
}

double mean_square_left(const Problem& problem, const std::string& symbol,
                        const std::vector<double>& predicted) {
  const auto measured = problem.data().values_of(symbol);
  double sum = 0, count = 0;
  for (const std::size_t row : problem.learn) {
    const double miss = measured[row] - predicted[row];
    if (!std::isfinite(miss)) continue;
    sum += miss * miss;
    count += 1;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace driftwise::diagnosis
