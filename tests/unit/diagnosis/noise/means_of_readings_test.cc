// Correlated noise of rows that are means of several readings, against the covariance summed
// reading by reading.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/shape_between.h"

namespace driftwise::diagnosis {
namespace means_of_readings_test {
namespace {

constexpr double kTau_s = 40, kRatio = 7;

// Means of two, three and four readings every 10 s, a pause after the 20th.
struct Means {
  Timeline timeline;
  Eigen::MatrixXd covariance;

  Means() {
    constexpr int kRows = 30;
    std::vector<std::vector<double>> readings_s(kRows);
    double at_s = 0;
    for (int row = 0; row < kRows; ++row) {
      if (row == 20) at_s += 170;
      for (int k = 0; k < 2 + row % 3; ++k, at_s += 10)
        readings_s[static_cast<std::size_t>(row)].push_back(at_s);
    }
    timeline.restart.assign(kRows, 0);
    timeline.restart[0] = timeline.restart[12] = 1;
    timeline.time_s.resize(kRows);
    timeline.readings.resize(kRows);
    timeline.span_s.resize(kRows);
    covariance = Eigen::MatrixXd::Identity(kRows, kRows);
    for (int i = 0; i < kRows; ++i) {
      const auto& of_row = readings_s[static_cast<std::size_t>(i)];
      timeline.time_s[i] = (of_row.front() + of_row.back()) / 2;
      timeline.readings[i] = static_cast<double>(of_row.size());
      timeline.span_s[i] = of_row.back() - of_row.front();
      for (int j = 0; j < kRows; ++j) {
        if ((i < 12) != (j < 12)) continue;
        const auto& of_other = readings_s[static_cast<std::size_t>(j)];
        double sum = 0;
        for (const double a : of_row)
          for (const double b : of_other) sum += std::exp(-std::abs(a - b) / kTau_s);
        covariance(i, j) += kRatio * sum / static_cast<double>(of_row.size() * of_other.size());
      }
    }
  }
};

TEST(MeansOfReadings, AreWhitenedAsTheirCovarianceIs) {
  const Means means;
  const Whitener whitener(means.timeline, {kRatio, kTau_s});
  const Eigen::LLT<Eigen::MatrixXd> dense(means.covariance);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(30, 30);
  whitener.apply(columns);
  const Eigen::MatrixXd expected = dense.matrixL().solve(Eigen::MatrixXd::Identity(30, 30));
  EXPECT_LT((columns - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(whitener.log_determinant(),
              2 * Eigen::MatrixXd(dense.matrixL()).diagonal().array().log().sum(), 1e-11);
}

TEST(MeansOfReadings, AreColouredTheOtherWay) {
  const Means means;
  const Whitener whitener(means.timeline, {kRatio, kTau_s});
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd white(30, 1);
  for (double& value : white.reshaped()) value = normal(random);
  Eigen::MatrixXd noise = white;
  whitener.colour(noise.col(0));
  whitener.apply(noise);
  EXPECT_LT((noise - white).cwiseAbs().maxCoeff(), 1e-12);
}

// Five thousand rows of a correlation of 0.8 from row to row: the grid has its time 1.7 times too
// long or short. Neighbours are then off by 0.02 where chance leaves 0.014 (three standard errors
// of the time itself are 8 %).
TEST(TheNoiseBetweenTheGridsShapes, HasTheTimeThatTheRowsHave) {
  Timeline timeline;
  constexpr Eigen::Index kRows = 5000;
  timeline.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, 10.0 * (kRows - 1));
  timeline.restart.assign(kRows, 0);
  timeline.restart.front() = 1;
  std::mt19937_64 random(3);
  const Eigen::MatrixXd mixing = Eigen::MatrixXd::Identity(1, 1);
  const Eigen::MatrixXd series = simulated_noise(timeline, {{5, 60}}, mixing, random);
  SoftBase base;
  base.columns = Eigen::MatrixXd::Ones(kRows, 1);
  const auto grid = noise_grid(timeline);
  const Ground on_grid(timeline, grid, base, series);
  const auto shapes = shapes_between(timeline, grid, on_grid, base, series, {});
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_NEAR(std::log(shapes[0].tau_s / 60), 0, 0.15);
  EXPECT_NEAR(std::log(shapes[0].slow_ratio / 5), 0, 0.25);
  const Ground fine(timeline, shapes, base, series);
  const Eigen::VectorXd left = fine.space(0, 0).left_over(series).col(0);
  const double neighbours = left.head(kRows - 1).dot(left.tail(kRows - 1)) / left.squaredNorm();
  EXPECT_LT(std::abs(neighbours), 0.03);
}

}  // namespace
}  // namespace means_of_readings_test
}  // namespace driftwise::diagnosis
