#include "server/identification/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/identification/identifiability.h"

namespace driftwise::identification {
namespace {

// NIST StRD nonlinear regression, Misra1a (lower difficulty) and MGH09 (higher difficulty), data
// and certified values: https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml
struct Curve {
  std::vector<double> x, y;
  std::function<double(double, const Eigen::VectorXd&)> value;
  std::function<Eigen::VectorXd(double, const Eigen::VectorXd&)> slope;
  Eigen::VectorXd start, certified, standard_error;
  double rss;
};

Eigen::VectorXd numbers(std::initializer_list<double> values) {
  Eigen::VectorXd vector(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), vector.begin());
  return vector;
}

Curve misra1a() {
  return {{77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1,
           760.0},
          {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40,
           75.47, 81.78},
          [](double x, const Eigen::VectorXd& b) { return b[0] * (1 - std::exp(-b[1] * x)); },
          [](double x, const Eigen::VectorXd& b) {
            return numbers({1 - std::exp(-b[1] * x), b[0] * x * std::exp(-b[1] * x)});
          },
          numbers({500, 0.0001}),
          numbers({2.3894212918E+02, 5.5015643181E-04}),
          numbers({2.7070075241E+00, 7.2668688436E-06}),
          1.2455138894E-01};
}

Curve mgh09() {
  return {{4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625},
          {0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246},
          [](double x, const Eigen::VectorXd& b) {
            return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]);
          },
          [](double x, const Eigen::VectorXd& b) {
            const double over = x * x + x * b[1], under = x * x + x * b[2] + b[3];
            const double all = b[0] * over / (under * under);
            return numbers({over / under, b[0] * x / under, -all * x, -all});
          },
          numbers({0.25, 0.39, 0.415, 0.39}),
          numbers({1.9280693458E-01, 1.9128232873E-01, 1.2305650693E-01, 1.3606233068E-01}),
          numbers({1.1435312227E-02, 1.9633220911E-01, 8.0842031232E-02, 9.0025542308E-02}),
          3.0750560385E-04};
}

class CertifiedCurve : public testing::TestWithParam<std::pair<const char*, Curve (*)()>> {};

TEST_P(CertifiedCurve, IsMetToTenDigitsWithItsStandardErrors) {
  const Curve curve = GetParam().second();
  const LeastSquaresProblem problem{
      [&](const Eigen::VectorXd& b) {
        Eigen::VectorXd left(static_cast<Eigen::Index>(curve.x.size()));
        for (std::size_t i = 0; i < curve.x.size(); ++i)
          left[static_cast<Eigen::Index>(i)] = curve.value(curve.x[i], b) - curve.y[i];
        return left;
      },
      [&](const Eigen::VectorXd& b) {
        Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(curve.x.size()), b.size());
        for (std::size_t i = 0; i < curve.x.size(); ++i)
          jacobian.row(static_cast<Eigen::Index>(i)) = curve.slope(curve.x[i], b).transpose();
        return jacobian;
      }};
  const auto solution = minimise(problem, curve.start);
  ASSERT_TRUE(solution) << solution.error().message;
  const double freedom =
      static_cast<double>(curve.x.size()) - static_cast<double>(curve.start.size());
  const Eigen::MatrixXd inverse = inverse_normal(problem.jacobian(solution->values));
  EXPECT_NEAR(solution->sum_of_squares, curve.rss, 1e-10 * curve.rss);
  for (Eigen::Index k = 0; k < curve.start.size(); ++k) {
    // The sum of squares is flat to half of the digits; standard errors follow it to 1e-6.
    EXPECT_NEAR(solution->values[k], curve.certified[k], 1e-6 * std::abs(curve.certified[k]));
    EXPECT_NEAR(std::sqrt(inverse(k, k) * solution->sum_of_squares / freedom),
                curve.standard_error[k], 1e-5 * curve.standard_error[k]);
  }
}

INSTANTIATE_TEST_SUITE_P(NistStrd, CertifiedCurve,
                         testing::Values(std::pair("Misra1a", &misra1a),
                                         std::pair("Mgh09", &mgh09)),
                         [](const auto& row) { return std::string(row.param.first); });

TEST(LeastSquares, RefusesMoreUnknownsThanResiduals) {
  const LeastSquaresProblem problem{
      [](const Eigen::VectorXd&) { return Eigen::VectorXd::Ones(2).eval(); },
      [](const Eigen::VectorXd&) { return Eigen::MatrixXd::Zero(2, 3).eval(); }};
  EXPECT_EQ(minimise(problem, Eigen::VectorXd::Zero(3)).error().reason, "TOO_FEW_ROWS");
}

TEST(LeastSquares, RefusesAStartThatGivesNoNumbers) {
  const LeastSquaresProblem problem{
      [](const Eigen::VectorXd&) { return Eigen::VectorXd::Constant(3, NAN).eval(); },
      [](const Eigen::VectorXd&) { return Eigen::MatrixXd::Zero(3, 1).eval(); }};
  EXPECT_EQ(minimise(problem, Eigen::VectorXd::Zero(1)).error().reason, "BAD_START");
}

TEST(LeastSquares, SaysHowFarItCameWhenItDoesNotArrive) {
  // exp(-x) has no minimum.
  const LeastSquaresProblem problem{
      [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, std::exp(-x[0])).eval(); },
      [](const Eigen::VectorXd& x) {
        return Eigen::MatrixXd::Constant(1, 1, -std::exp(-x[0])).eval();
      }};
  const auto solution = minimise(problem, Eigen::VectorXd::Zero(1), 10);
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().reason, "NO_CONVERGENCE");
  EXPECT_NE(solution.error().message.find("10 evaluations"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::identification
