// What a row is off by itself, against generalised least squares with the whole covariance; and the
// chance of gross errors where noise has heavy tails, against rows drawn so.

#include "server/diagnosis/noise/own_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "server/diagnosis/noise/tails.h"

namespace driftwise::diagnosis {
namespace own_rows_test {
namespace {

using ::testing::ElementsAre;

constexpr Eigen::Index kRows = 60;
constexpr double kStep_s = 30, kTau_s = 90, kRatio = 6;

Timeline timeline() {
  Timeline result;
  result.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, kStep_s * (kRows - 1));
  result.restart.assign(kRows, 0);
  result.restart.front() = 1;
  return result;
}

Eigen::MatrixXd simulation() {
  Eigen::MatrixXd base = Eigen::MatrixXd::Ones(kRows, 2);
  base.col(1) = Eigen::VectorXd::LinSpaced(kRows, -1, 1);
  return base;
}

Eigen::MatrixXd covariance() {
  return Eigen::MatrixXd::NullaryExpr(kRows, kRows, [](Eigen::Index i, Eigen::Index k) {
    return kRatio * std::exp(-kStep_s * std::abs(static_cast<double>(i - k)) / kTau_s) +
           (i == k ? 1 : 0);
  });
}

Eigen::VectorXd drawn(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd root = covariance().llt().matrixL();
  return root * Eigen::VectorXd::NullaryExpr(kRows, [&] { return normal(random); });
}

WhitenedSpace space() { return {timeline(), {kRatio, kTau_s}, SoftBase(simulation())}; }

TEST(OwnRows, AreOffByTheirCoefficientOverItsStandardError) {
  const Eigen::VectorXd series = drawn(1);
  const auto at = space();
  const OwnRows own = own_rows(at, at.left_over(series));
  const Eigen::MatrixXd inverse = covariance().inverse();
  for (Eigen::Index i = 0; i < kRows; ++i) {
    Eigen::MatrixXd columns(kRows, 3);
    columns << simulation(), Eigen::VectorXd::Unit(kRows, i);
    const Eigen::Matrix3d spread = (columns.transpose() * inverse * columns).inverse();
    const Eigen::Vector3d fitted = spread * (columns.transpose() * inverse * series);
    EXPECT_NEAR(own.off(i, 0), fitted[2] / std::sqrt(spread(2, 2)), 1e-8) << i;
    EXPECT_NEAR(own.length[i], 1 / std::sqrt(spread(2, 2)), 1e-8) << i;
  }
}

// 20 of the noise at row 30: rows 29 and 31 are off by 7 and more, for they agree with one another.
TEST(OwnRows, BesideAWrongOneAreRightBeyondIt) {
  Eigen::VectorXd series = drawn(2);
  series[30] += 20 * std::sqrt(1 + kRatio);
  const auto at = space();
  const Eigen::VectorXd off = own_rows(at, at.left_over(series)).off;
  ASSERT_GT(std::min(std::abs(off[29]), std::abs(off[31])), 7);
  EXPECT_THAT(beyond_the_farther(at, off, {29, 30, 31}), ElementsAre(30));
}

TEST(OwnRows, OfWhichTwoInSuccessionAreWrongAreBothFound) {
  Eigen::VectorXd series = drawn(3);
  series.segment(30, 2).array() += 20 * std::sqrt(1 + kRatio);
  const auto at = space();
  const Eigen::VectorXd off = own_rows(at, at.left_over(series)).off;
  EXPECT_THAT(beyond_the_farther(at, off, {29, 30, 31, 32}), ElementsAre(30, 31));
}

// 60 files of 200 rows with the tails of Student's law with three degrees of freedom: one in ten
// has a gain of chance 0.1 or less. Binomial, 99.9 %: 0 to 14.
TEST(ChanceOfGross, IsAsOftenInHeavyTailsAsItSays) {
  std::mt19937_64 random(4);
  std::student_t_distribution<double> heavy(3);
  int below = 0;
  for (int k = 0; k < 60; ++k) {
    const std::vector<Tails> tails = {
        Tails(Eigen::VectorXd::NullaryExpr(200, [&] { return heavy(random); }))};
    const double gain = gross_gain(tails, 0).gain;
    below += gain > 2 && chance_of_gross(tails, 200, gain) <= 0.09 ? 1 : 0;
  }
  EXPECT_LE(below, 14);
}

}  // namespace
}  // namespace own_rows_test
}  // namespace driftwise::diagnosis
