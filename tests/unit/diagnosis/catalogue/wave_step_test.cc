#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/diagnosis/catalogue/cause.h"

namespace driftwise::diagnosis {
namespace {

constexpr int kWaveRows = 200;
constexpr double kBetweenWaveRows_s = 10;

Dataset rows_of_waves() {
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (int i = 0; i < kWaveRows; ++i) {
    data.time_s.push_back(kBetweenWaveRows_s * i);
    for (auto& column : data.columns) column.values.push_back(std::fmod(i * 0.618034, 1.0) * 10);
    ++data.rows;
  }
  return data;
}

Eigen::MatrixXd wave_about_mean(double period_s) {
  Eigen::MatrixXd columns(kWaveRows, 3);
  for (int i = 0; i < kWaveRows; ++i) {
    const double phase = 2 * std::numbers::pi * kBetweenWaveRows_s * i / period_s;
    columns.row(i) << 1, std::sin(phase), std::cos(phase);
  }
  return columns;
}

// Largest share of a wave's square, about its mean, that one period of the grid describes.
double kept_by_the_grid(const Cause& cause, double period_s, double phase) {
  Eigen::VectorXd y =
      wave_about_mean(period_s).rightCols(2) * Eigen::Vector2d(std::cos(phase), std::sin(phase));
  y.array() -= y.mean();
  double most = 0;
  for (const auto& cell : cause.cells) {
    if (std::abs(1 / cell.parameter - 1 / period_s) > 2 / (kWaveRows * kBetweenWaveRows_s))
      continue;
    const Eigen::MatrixXd columns = wave_about_mean(cell.parameter);
    const Eigen::VectorXd left = y - columns * columns.colPivHouseholderQr().solve(y);
    most = std::max(most, 1 - left.squaredNorm() / y.squaredNorm());
  }
  return most;
}

// A wave a quarter of a turn off its cell over the data would keep sinc^2(1 / 4) = 81 %, one an
// eighth off 95 %. Both are of long data; the mean, and the wave's two ends, change it by some 2 %.
TEST(Waves, BetweenTwoPeriodsOfTheGridKeepTheirEvidence) {
  const auto catalogue = catalogue_for(rows_of_waves(), {{{effects::Power{"x", 1}}}}, {});
  const auto cause = std::ranges::find(catalogue.causes, "periodic_disturbance", &Cause::id);
  ASSERT_NE(cause, catalogue.causes.end());
  for (double turns = 3; turns < 16; turns += 0.0625 * std::numbers::sqrt2)
    for (const double phase : {0.0, 1.0, 2.0})
      EXPECT_GT(kept_by_the_grid(*cause, (kWaveRows - 1) * kBetweenWaveRows_s / turns, phase), 0.93)
          << turns << " turns";
}

}  // namespace
}  // namespace driftwise::diagnosis
