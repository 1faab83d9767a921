// The predicted pose of a robot whose motors are polynomials of the pose: the pose is none of
// theirs, and a wave of a laser asks for it to a fraction of 633 nm.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/predicted_pose.h"
#include "server/diagnosis/rows/problem.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kNoise_mm = 20e-6;

// 11 x 11 motor positions within 50 mm, three rounds; what it is measured at, and where it is.
struct CurvedRobot {
  Dataset data;
  std::vector<double> x_mm, y_mm;  // true

  CurvedRobot() {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::vector<double> q1, q2, x, y;
    for (int row = 0; row < 363; ++row) {
      q1.push_back(10.0 * (row % 11) - 50);
      q2.push_back(10.0 * (row / 11 % 11) - 50);
      double at_x = q1.back(), at_y = q2.back();
      for (int round = 0; round < 100; ++round) {  // x = q1 - what else is in q1
        const double x_now = at_x, y_now = at_y;
        at_x = q1.back() - 1e-3 * x_now * y_now - 5e-4 * x_now * x_now;
        at_y = q2.back() - 1e-3 * y_now * y_now + 5e-4 * x_now * y_now;
      }
      x_mm.push_back(at_x);
      y_mm.push_back(at_y);
      x.push_back(at_x + kNoise_mm * normal(random));
      y.push_back(at_y + kNoise_mm * normal(random));
      data.time_s.push_back(30.0 * row);
    }
    data.rows = q1.size();
    data.columns = {{{"q1", "mm"}, q1}, {{"q2", "mm"}, q2}, {{"x", "mm"}, x}, {{"y", "mm"}, y}};
  }
};

double rms(std::span<const double> predicted, const std::vector<double>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) sum += std::pow(predicted[i] - truth[i], 2);
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

TEST(PredictedPose, IsWhereTheBaselineHasTheMotors) {
  const CurvedRobot robot;
  const auto polynomial = predicted_coordinate(robot.data, "x");
  ASSERT_TRUE(polynomial);
  ASSERT_GT(rms(*polynomial, robot.x_mm), 633e-6) << "or there is nothing to be gained";
  const auto problem = lay_out(
      robot.data, *formats::Formula::parse("q ~ poly(x, y, 2)")->expand(robot.data), kMostSearched);
  ASSERT_TRUE(problem);
  const auto& at = problem->prepared.conditions();
  EXPECT_LT(rms(at.values_of("x"), robot.x_mm), kNoise_mm / 2);
  EXPECT_LT(rms(at.values_of("y"), robot.y_mm), kNoise_mm / 2);
}

// A baseline of the first degree: the motors' polynomial is nearer, and stays.
TEST(PredictedPose, IsNotTheOneOfABaselineThatLacksTheCurvature) {
  const CurvedRobot robot;
  const auto polynomial = predicted_coordinate(robot.data, "x");
  ASSERT_TRUE(polynomial);
  const auto problem = lay_out(
      robot.data, *formats::Formula::parse("q ~ poly(x, y, 1)")->expand(robot.data), kMostSearched);
  ASSERT_TRUE(problem);
  EXPECT_DOUBLE_EQ(rms(problem->prepared.conditions().values_of("x"), robot.x_mm),
                   rms(*polynomial, robot.x_mm));
}

}  // namespace
}  // namespace driftwise::diagnosis
