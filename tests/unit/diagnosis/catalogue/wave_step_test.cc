#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/catalogue/physics.h"
#include "server/diagnosis/rows/problem.h"

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

// A sin(2 pi x / P) is no steeper than 2 pi A / P: above the motor's own slope over x, or above one
// where that is less, a scale would read backwards.
TEST(Waves, AreNoSteeperThanTheirCoordinate) {
  for (const double slope : {0.1, 1.0, 10.0}) {
    Dataset data = rows_of_waves();
    for (std::size_t i = 0; i < data.rows; ++i)
      data.columns[0].values[i] =
          slope * data.columns[1].values[i] + 60e-6 * std::sin(static_cast<double>(i * i));
    calibration::Candidates baseline;
    baseline.outputs = {"q1"};
    baseline.terms = {{{effects::Power{"x", 1}}}};
    const auto problem = lay_out(data, baseline, kMostSearched);
    ASSERT_TRUE(problem) << problem.error().message;
    const Physics physics(*problem, std::nullopt);
    const auto catalogue = catalogue_for(data, baseline.terms, {});
    const auto cause = std::ranges::find(catalogue.causes, "cyclic_error", &Cause::id);
    ASSERT_NE(cause, catalogue.causes.end());
    for (const double period_nm : {128.0, 500.0, 1e6}) {
      const std::vector<effects::Term> wave = {
          {{effects::Call{"sin", {"x"}, {{period_nm, "nm"}}}}},
          {{effects::Call{"cos", {"x"}, {{period_nm, "nm"}}}}}};
      const auto columns = problem->prepared.columns(wave);
      ASSERT_TRUE(columns);
      const auto prior = physics.prior(*cause, wave, period_nm, problem->learned(*columns));
      const double most_nm = std::max(slope, 1.0) * period_nm / (2 * std::numbers::pi);
      EXPECT_LE(prior.range.maxCoeff(), 1.001 * most_nm) << slope << ", " << period_nm << " nm";
      if (period_nm < 1e3) {
        EXPECT_GT(prior.range.minCoeff(), 0.999 * most_nm) << "the noise would allow more";
      }
    }
  }
}

}  // namespace
}  // namespace driftwise::diagnosis
