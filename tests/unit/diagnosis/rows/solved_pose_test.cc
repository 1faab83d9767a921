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

// Places that an operator typed in thousandths of 4.271 mm, 13.5 half wavelengths of a laser apart,
// a servo that comes to rest within 20 nm of them, and a pose of 25 nm noise on a display of 41.5
// nm, which shows values again and again.
Dataset typed_places_and_a_display(unsigned seed) {
  constexpr double kGrid_mm = 4.271e-3, kDisplay_mm = 41.4755e-6;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> places, q1, x, t01;
  for (int k = 0; k < 40; ++k)
    places.push_back(kGrid_mm * (static_cast<double>(random() % 200) - 100));
  Dataset data;
  for (int row = 0; row < 90; ++row) {
    const double warm_k = 0.5 * std::sin(row / 14.0) + 1e-3 * normal(random);
    q1.push_back(places[random() % places.size()] + 20e-6 * normal(random));
    t01.push_back(20 + warm_k);
    const double pose = q1.back() + 400e-6 * warm_k + 25e-6 * normal(random);
    x.push_back(kDisplay_mm * std::round(pose / kDisplay_mm));
    data.time_s.push_back(60.0 * row);
  }
  data.rows = q1.size();
  data.columns = {{{"q1", "mm"}, q1}, {{"x", "mm"}, x}, {{"t01", "degC"}, t01}};
  return data;
}

// Waves along q1 then go with q1 as it was read: with what the baseline predicts of it from the
// display they would go with the display's noise.
TEST(ADisplayInFineSteps, IsNoPlanThatTheMachineWasSentBy) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Dataset data = typed_places_and_a_display(seed);
    EXPECT_TRUE(is_read_in_steps(data.columns[1].values, 25e-6)) << "seed " << seed;
    const auto problem =
        lay_out(data, *formats::Formula::parse("q1 ~ x + T")->expand(data), kMostSearched);
    ASSERT_TRUE(problem);
    const auto phase = problem->prepared.phase_values("q1");
    for (std::size_t row = 0; row < data.rows; ++row)
      EXPECT_NEAR(phase[row], data.columns[0].values[row], 100e-6) << "seed " << seed;
    EXPECT_LT(rms(phase, data.columns[0].values), 20e-6) << "seed " << seed;
  }
}

// Rows of a further datum are moved to the first one's frame, by less than the noise here.
TEST(APlan, OfTwoDatumsIsNoDisplay) {
  Dataset data;
  std::vector<double> x;
  for (int row = 0; row < 400; ++row) {
    data.datum.push_back(row / 200);
    x.push_back(0.012 * (row * 309 % 500) + (row < 200 ? 0 : 20e-6));
  }
  data.rows = x.size();
  EXPECT_FALSE(is_read_in_steps(data, x, 25e-6));
}

TEST(APlan, IsNoDisplay) {
  std::vector<double> lattice, fine;
  for (int k = 0; k < 200; ++k) {
    lattice.push_back(0.1 * (k % 18));
    fine.push_back(1e-5 * k);
  }
  EXPECT_FALSE(is_read_in_steps(lattice, 25e-6));
  EXPECT_FALSE(is_read_in_steps(fine, 25e-6));  // nearer than the noise, but none left out
}

}  // namespace
}  // namespace driftwise::diagnosis
