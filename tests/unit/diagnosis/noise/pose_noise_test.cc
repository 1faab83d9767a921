// Noise of a robot whose motors are curved functions of the pose: what stands in the pose's
// readings is in a motor as large as its slopes make it there.

#include "server/diagnosis/pose_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/noise/noise_model.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kNoise_mm = 20e-6;
// dq1/dx goes from 0.5 to 1.5 over the range, and so does dq2/dy.
constexpr double kCurvature = 0.005;

enum class NoiseOf { pose, motors };

// 240 places at random within 50 mm of the middle.
Dataset curved_robot(NoiseOf noise_of) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> within(-50, 50);
  std::vector<double> q1, q2, x, y;
  Dataset data;
  data.rows = 240;
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double at_x = within(random), at_y = within(random);
    const bool of_pose = noise_of == NoiseOf::pose;
    const double e1 = kNoise_mm * normal(random), e2 = kNoise_mm * normal(random);
    q1.push_back(at_x + kCurvature * at_x * at_x + 0.2 * at_y + (of_pose ? 0 : e1));
    q2.push_back(at_y + kCurvature * at_y * at_y + (of_pose ? 0 : e2));
    x.push_back(at_x + (of_pose ? e1 : 0));
    y.push_back(at_y + (of_pose ? e2 : 0));
    data.time_s.push_back(30.0 * static_cast<double>(row));
  }
  data.columns = {{{"q1", "mm"}, q1}, {{"q2", "mm"}, q2}, {{"x", "mm"}, x}, {{"y", "mm"}, y}};
  return data;
}

Problem laid_out(const Dataset& data) {
  auto problem =
      lay_out(data, *formats::Formula::parse("q ~ poly(x, y, 2)")->expand(data), kMostSearched);
  EXPECT_TRUE(problem) << problem.error().message;
  return *std::move(problem);
}

TEST(PoseNoise, IsAsLargeAsTheSlopesMakeIt) {
  const Dataset data = curved_robot(NoiseOf::pose);
  const Problem problem = laid_out(data);
  const auto noise = pose_noise(problem);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->ratio, 3, 0.3);
  // By calculus: the slope of q2 along y, over its root mean square on the rows.
  double squares = 0;
  for (const double y : data.values_of("y")) squares += std::pow(1 + 2 * kCurvature * y, 2);
  const double usual = std::sqrt(squares / static_cast<double>(data.rows));
  for (std::size_t row = 0; row < data.rows; ++row) {
    const auto at = static_cast<Eigen::Index>(row);
    const double slope = (1 + 2 * kCurvature * data.values_of("y")[row]) / usual;
    EXPECT_NEAR(noise->of_row[at] * noise->own(at, 1), slope, 0.1) << "row " << row;
  }
}

TEST(PoseNoise, IsNothingWhereTheNoiseIsTheMotors) {
  EXPECT_FALSE(pose_noise(laid_out(curved_robot(NoiseOf::motors))));
}

// Nothing hidden, and noise of each motor that goes with its own coordinate.
TEST(PoseNoise, IsNoStructureAndHasNoWrongRows) {
  const auto found = diagnosed(curved_robot(NoiseOf::pose), "q ~ poly(x, y, 2)");
  EXPECT_EQ(found.verdict, Verdict::adequate);
  EXPECT_TRUE(found.findings.empty());
}

TEST(SimulatedNoise, HasASpreadOfItsOwnInEachSeries) {
  constexpr Eigen::Index kRows = 20000;
  Timeline timeline;
  timeline.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, kRows - 1);
  timeline.restart.assign(kRows, 0);
  timeline.restart.front() = 1;
  timeline.own_sd = Eigen::MatrixXd::Ones(kRows, 2);
  timeline.own_sd.col(1).head(kRows / 2).setConstant(3);
  std::mt19937_64 random(11);
  const auto series =
      simulated_noise(timeline, {{1, 5}, {1, 5}}, Eigen::Matrix2d::Identity(), random);
  const auto rms = [](const auto& values) {
    return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
  };
  EXPECT_NEAR(rms(series.col(1).head(kRows / 2)) / rms(series.col(1).tail(kRows / 2)), 3, 0.1);
  EXPECT_NEAR(rms(series.col(0).head(kRows / 2)) / rms(series.col(0).tail(kRows / 2)), 1, 0.05);
}

}  // namespace
}  // namespace driftwise::diagnosis
