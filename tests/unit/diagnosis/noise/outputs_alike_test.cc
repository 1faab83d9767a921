// Outputs whose noise hangs together: the legs of a hexapod, each of which has the noise of every
// instrument behind it. A chance in one instrument is a chance in all legs, and counts once.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {
namespace outputs_alike_test {
namespace {

constexpr Eigen::Index kRows = 200;

Timeline timeline() {
  Timeline result;
  result.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, 30.0 * (kRows - 1));
  result.restart.assign(kRows, 0);
  result.restart.front() = 1;
  return result;
}

Eigen::MatrixXd normal_columns(Eigen::Index count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, count, [&] { return normal(random); });
}

TEST(CountedTimes, IsTheVarianceAlongTheGains) {
  const Eigen::MatrixXd apart = Eigen::MatrixXd::Identity(3, 3);
  const Eigen::MatrixXd alike = Eigen::MatrixXd::Ones(3, 3);
  EXPECT_DOUBLE_EQ(counted_times(Eigen::Vector3d(4, 9, 1), apart), 1);
  EXPECT_DOUBLE_EQ(counted_times(Eigen::Vector3d(5, 5, 5), alike), 3);
  EXPECT_DOUBLE_EQ(counted_times(Eigen::Vector3d(5, 0, -2), alike), 1) << "one gains alone";
  EXPECT_DOUBLE_EQ(counted_times(Eigen::Vector3d(0, 0, 0), alike), 1);
  EXPECT_DOUBLE_EQ(counted_times(Eigen::Vector3d(4, 1, 0), alike), (2.0 + 1) * (2 + 1) / 5);
}

TEST(OutputsAlike, LeavesWhatChanceGivesToNone) {
  Eigen::Matrix2d correlation;
  correlation << 1, -0.12, -0.12, 1;
  EXPECT_EQ(outputs_alike(correlation, 256)(0, 1), 0) << "two standard errors are 0.125";
  correlation << 1, -0.9, -0.9, 1;
  EXPECT_NEAR(outputs_alike(correlation, 256)(0, 1), (0.9 - 0.125) / 0.875, 1e-12);
}

// 400 columns of nothing on six outputs that all read one noise: twice the log-likelihood grows by
// chi squared of one degree of freedom, not of six times as much.
TEST(Evidence, OfNothingOnSixOutputsWithOneNoiseIsThatOfOne) {
  std::mt19937_64 random(41);
  const Eigen::MatrixXd one = normal_columns(1, random);
  Eigen::MatrixXd series = one.replicate(1, 6) + 0.05 * normal_columns(6, random);
  const Ground ground(timeline(), {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  double sum = 0;
  int beyond = 0;  // 10.83: one in a thousand of chi squared with one degree of freedom
  for (int i = 0; i < 400; ++i) {
    const Gain gain = ground.gain(normal_columns(1, random), Eigen::MatrixXd::Constant(1, 6, 1000));
    sum += gain.likelihood;
    beyond += gain.likelihood > 10.83 ? 1 : 0;
  }
  EXPECT_NEAR(sum / 400, 1, 0.25);
  EXPECT_LE(beyond, 3);
}

TEST(Scan, CountsAChanceOnceAsTheSearchOneByOneDoes) {
  std::mt19937_64 random(43);
  const Eigen::MatrixXd one = normal_columns(1, random);
  const Eigen::MatrixXd series = one.replicate(1, 3) + 0.4 * normal_columns(3, random);
  Bank bank;
  bank.columns = normal_columns(4, random);
  bank.prior = Eigen::MatrixXd::Constant(4, 3, 0.8);
  bank.cells = {{0, 2}, {2, 2}};
  bank.ln_weight = {0, 0};
  bank.entries = {{0, 1}, {1, 1}};
  std::vector<Eigen::MatrixXd> separate;
  for (Eigen::Index o = 0; o < 3; ++o) separate.emplace_back(series.col(o));
  const Ground ground(timeline(), {{0, 1}, {1, 60}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)),
                      series);
  ASSERT_GT(ground.alike()(0, 1), 0.5);
  const auto best = scan(bank, ground, separate, {1, 1}, {{}, {}});
  for (std::size_t e = 0; e < 2; ++e)
    EXPECT_NEAR(best[e][0].gain,
                ground
                    .gain(bank.columns.middleCols(bank.cells[e].first, 2),
                          bank.prior.middleRows(bank.cells[e].first, 2))
                    .gain,
                1e-3);
}

}  // namespace
}  // namespace outputs_alike_test
}  // namespace driftwise::diagnosis
