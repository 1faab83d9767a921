// A field of random amplitudes beside the noise: its growth of 2 ln L against dense covariance
// matrices, and a product of place and time seen by the omnibus test.

#include "server/diagnosis/noise/random_field.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/diagnosis/growth/left_by_a_parabola.h"

namespace driftwise::diagnosis {
namespace random_field_test {  // other tests have rows of their own
namespace {

constexpr Eigen::Index kRows = 60;
constexpr double kNoClip = 1e9;
constexpr double kSinglePrecision = 1e-4;  // in 2 ln L of 60 rows

Timeline even_timeline() {
  Timeline when;
  when.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, 20.0 * (kRows - 1));
  when.restart.assign(kRows, 0);
  when.restart.front() = 1;
  return when;
}

Eigen::MatrixXd drawn(Eigen::Index columns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, columns, [&] { return normal(random); });
}

double log_determinant(const Eigen::MatrixXd& positive) {
  const Eigen::MatrixXd factor = positive.llt().matrixL();
  return 2 * factor.diagonal().array().log().sum();
}

// Twice the negative restricted log-likelihood with the white variance at its best.
double dense_criterion(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& x,
                       const Eigen::VectorXd& y) {
  const Eigen::MatrixXd inverse = covariance.inverse(), information = x.transpose() * inverse * x;
  const Eigen::VectorXd left =
      inverse * y - inverse * x * information.inverse() * x.transpose() * inverse * y;
  return static_cast<double>(kRows - x.cols()) * std::log(y.dot(left)) +
         log_determinant(covariance) + log_determinant(information);
}

TEST(RandomField, GrowsAsTheDenseRestrictedLikelihoodSays) {
  const Timeline when = even_timeline();
  const std::vector<NoiseShape> shapes = {{0, 1}, {3, 200}};
  Eigen::MatrixXd base = drawn(3, 1);
  base.col(0).setOnes();
  const Eigen::MatrixXd field = drawn(4, 2);
  Eigen::MatrixXd series = drawn(2, 3);
  series.col(1) += 1.5 * field.col(0) - field.col(3);

  const RandomField fields(when, shapes, SoftBase(base), kNoClip);
  const Eigen::MatrixXd growth = fields.growth(field, fields.see({series}));

  for (Eigen::Index k = 0; k < series.cols(); ++k) {
    double without = INFINITY, with = INFINITY;
    for (const auto& shape : shapes) {
      Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(kRows, kRows);
      for (Eigen::Index i = 0; i < kRows; ++i)
        for (Eigen::Index j = 0; j < kRows; ++j)
          covariance(i, j) +=
              shape.slow_ratio * std::exp(-std::abs(when.time_s[i] - when.time_s[j]) / shape.tau_s);
      without = std::min(without, dense_criterion(covariance, base, series.col(k)));
      for (const double rho : {0.03, 0.1, 0.3, 1.0, 3.0, 10.0})
        with = std::min(with, dense_criterion(covariance + rho / 4 * field * field.transpose(),
                                              base, series.col(k)));
    }
    EXPECT_NEAR(growth(0, k), std::max(without - with, 0.0), kSinglePrecision) << k;
  }
  EXPECT_GT(growth(0, 1), 20);  // the second series has the field in it
}

// Free and prior columns in the base: products of what project() leaves of each column.
TEST(WhitenedSpaceGram, IsThatOfTheProjectedColumns) {
  const Eigen::VectorXd precision = (Eigen::VectorXd(5) << 0, 0, 0, 0.5, 20).finished();
  const SoftBase base(drawn(5, 6), precision);
  const WhitenedSpace space(even_timeline(), {3, 200}, base);
  const Eigen::MatrixXd white = drawn(7, 7);
  Eigen::MatrixXd projected = white;
  space.project(projected);
  const Eigen::MatrixXd expected = projected.transpose() * projected;
  EXPECT_NEAR((space.gram_beyond(white) - expected).norm(), 0, 1e-10 * expected.norm());
}

TEST(RandomField, OfColumnsThatTheBaseHasGrowsNothing) {
  const Timeline when = even_timeline();
  const Eigen::MatrixXd base = drawn(3, 4);
  const RandomField fields(when, {{0, 1}}, SoftBase(base), kNoClip);
  const Eigen::MatrixXd growth = fields.growth(base.col(1), fields.see({drawn(5, 5)}));
  EXPECT_NEAR(growth.maxCoeff(), 0, 1e-9);
}

// An axis of 12 places, driven along in a direction drawn for each line; error_sd: of a wave over
// the stroke that comes and goes three times, in standard deviations of the white noise.
double p_of_an_axis(double error_sd) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 192;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  constexpr double kNoiseMm = 5e-6;
  bool forth = true;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const auto t = static_cast<double>(i) / static_cast<double>(data.rows);
    const auto along = static_cast<double>(i % 12);
    if (i % 12 == 0) forth = random() % 2 == 0;
    const double u = (forth ? along : 11 - along) / 5.5 - 1;
    const double error = std::sin(1.4 * std::numbers::pi * u + 0.5) *
                         std::sin(6 * std::numbers::pi * t + 0.3) * 2;  // unit rms
    data.time_s.push_back(20.0 * static_cast<double>(i));
    data.columns[0].values.push_back(4 * u);
    data.columns[1].values.push_back(4 * u + kNoiseMm * (error_sd * error + normal(random)));
  }
  return left_by_a_parabola(data).p;
}

// rms 0.88 of the noise over 192 rows: chi2 150.
TEST(ProductOfPlaceAndTime, IsSeen) { EXPECT_LE(p_of_an_axis(0.88), kOmnibusLevel); }

TEST(ProductOfPlaceAndTime, IsSeenNowhereWhereThereIsNone) {
  EXPECT_GT(p_of_an_axis(0), kOmnibusLevel);
}

}  // namespace
}  // namespace random_field_test
}  // namespace driftwise::diagnosis
