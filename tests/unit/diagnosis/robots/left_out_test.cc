// Prediction of rows left out, against a joint normal density of all rows.

#include "server/diagnosis/robot/left_out.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

struct Example {
  Eigen::MatrixXd base, own;
  Eigen::VectorXd y;
};

// Two outputs of `rows` rows; base orthonormal, own beyond it.
Example example(Index rows, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](Index columns) {
    return Eigen::MatrixXd::NullaryExpr(2 * rows, columns, [&] { return normal(random); }).eval();
  };
  Example made;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(draw(3));
  made.base = qr.householderQ() * Eigen::MatrixXd::Identity(2 * rows, 3);
  made.own = draw(1);
  made.own -= made.base * (made.base.transpose() * made.own);
  made.y = draw(1) + size * made.own;
  return made;
}

// 2 ln of the density of the judged values given the known ones, amplitudes integrated out.
double conditional(const Eigen::MatrixXd& columns, const Eigen::VectorXd& prior_sd,
                   const Eigen::VectorXd& y, const std::vector<Index>& known,
                   const std::vector<Index>& judged) {
  const Eigen::MatrixXd all = columns * prior_sd.cwiseAbs2().asDiagonal() * columns.transpose() +
                              Eigen::MatrixXd::Identity(y.size(), y.size());
  const Eigen::MatrixXd cross = all(judged, known), of_known = all(known, known);
  const Eigen::MatrixXd gain = of_known.ldlt().solve(cross.transpose()).transpose();
  const Eigen::MatrixXd covariance = all(judged, judged) - gain * cross.transpose();
  const Eigen::VectorXd e = y(judged) - gain * y(known);
  return -e.dot(covariance.ldlt().solve(e)) - std::log(covariance.determinant()) -
         static_cast<double>(judged.size()) * std::log(2 * std::numbers::pi);
}

TEST(LeftOut, GrowthIsThatOfTheConditionalDensity) {
  const Index rows = 12;
  const auto [base, own, y] = example(rows, 0.6, 3);
  const double sd = 0.8;
  const LeftOut left_out(base, own, Eigen::VectorXd::Constant(1, 1 / (sd * sd)), 1, y, rows);
  const Folds folds = {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}};
  Eigen::MatrixXd both(2 * rows, 4);
  both << base, own;
  const double free = 3e3;  // of the base, which has no prior
  double growth = 0;
  for (const auto& fold : folds) {
    std::vector<Index> judged, known;
    for (Index i = 0; i < 2 * rows; ++i) {
      const bool out = std::ranges::count(fold, static_cast<std::size_t>(i % rows)) > 0;
      (out ? judged : known).push_back(i);
    }
    growth += conditional(both, Eigen::Vector4d(free, free, free, sd), y, known, judged) -
              conditional(base, Eigen::Vector3d(free, free, free), y, known, judged);
  }
  EXPECT_NEAR(left_out.growth(folds), growth, 1e-3);
}

TEST(LeftOut, SizeHoldsWhereEveryPartAsksForIt) {
  const Index rows = 60;
  const auto [base, own, y] = example(rows, 1, 4);
  const auto parts = folds_of_driver(Eigen::VectorXd::LinSpaced(rows, 0, 1));
  const auto t_of = [&](const Eigen::VectorXd& values) {
    return LeftOut(base, own, Eigen::VectorXd::Zero(1), 1, values, rows).t_without(parts);
  };
  EXPECT_GT(t_of(y), 5);
  // ... grows with it, however unevenly the parts show it,
  EXPECT_NEAR(t_of(y + 9 * own.col(0)) / t_of(y), 10, 1);
  // ... and is nothing where one part alone has it.
  Eigen::VectorXd once = y - own.col(0);
  for (const std::size_t row : parts.back())
    for (const Index at : {static_cast<Index>(row), static_cast<Index>(row) + rows})
      once[at] += 3 * own(at, 0);
  EXPECT_LT(t_of(once), 2);
}

TEST(LeftOut, PartsOfADriverHaveAsManyRowsEach) {
  Eigen::VectorXd driver(13);
  driver << 9, 1, 8, 2, 7, 3, 6, 4, 5, 0, 10, 12, 11;
  const auto parts = folds_of_driver(driver);
  ASSERT_EQ(parts.size(), 6U);
  EXPECT_EQ(parts.front(), (std::vector<std::size_t>{9, 1, 3}));
  EXPECT_EQ(parts.back(), (std::vector<std::size_t>{12, 11}));
}

}  // namespace
}  // namespace driftwise::diagnosis
