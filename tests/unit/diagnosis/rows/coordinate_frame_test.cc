// Two legs that carry a platform: a length and a tilt are in both. Plain formulas of both legs.

#include "server/diagnosis/search/coordinate_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <random>

#include "server/diagnosis/diagnose.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace coordinate_frame_test {  // other tests have rows of their own
namespace {

constexpr double kNoise_nm = 5, kTiltNoise_arcsec = 0.2;  // 100 nm in each leg
constexpr double kLever = 5e-4, kTwist = 4e-5;            // mm/arcsec, and per mm of the stroke
constexpr std::size_t kRows = 400;

struct Legs {
  double q1, q2;
};
Legs two_legs(double x, double rx) {
  return {x + kLever * rx + kTwist * x * rx, x - kLever * rx + 0.5 * kTwist * x * rx};
}
Legs one_motor_each(double x, double rx) { return {x, kLever * rx}; }

// step_nm: of the reading of x, from the middle on.
template <typename Motors>
Dataset measured(unsigned seed, const Motors& motors, double step_nm = 0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  Dataset data;
  data.rows = kRows;
  data.columns = {
      {{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}, {{"x", "mm"}, {}}, {{"rx", "arcsec"}, {}}};
  for (std::size_t i = 0; i < kRows; ++i) {
    const double x = 4 * uniform(random), rx = 200 * uniform(random);
    const Legs legs = motors(x, rx);
    data.time_s.push_back(20.0 * static_cast<double>(i));
    data.columns[0].values.push_back(legs.q1);
    data.columns[1].values.push_back(legs.q2);
    data.columns[2].values.push_back(x + 1e-6 * kNoise_nm * normal(random) +
                                     (i < kRows / 2 ? 0 : 1e-6 * step_nm));
    data.columns[3].values.push_back(rx + kTiltNoise_arcsec * normal(random));
  }
  return data;
}

calibration::Candidates second_degree(const Dataset& data) {
  return *formats::Formula::parse("q ~ poly(x, rx, 2)")->expand(data);
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

TEST(CoordinateFrame, HasTheNoiseOfEachCoordinateByItself) {
  const Dataset data = measured(1, two_legs);
  const auto problem = lay_out(data, second_degree(data), 4000);
  ASSERT_TRUE(problem);
  const auto frame = in_coordinates(*problem);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->problem.outputs.size(), 2U);
  EXPECT_EQ(frame->problem.outputs[0].channel.symbol, "x");
  EXPECT_EQ(frame->problem.outputs[1].unit, "arcsec");
  const Eigen::MatrixXd base = frame->problem.learned(frame->problem.base_columns);
  const Eigen::MatrixXd series = frame->problem.series();
  const Eigen::MatrixXd left = series - base * base.colPivHouseholderQr().solve(series);
  // Standard error of a spread of 400 rows: 3.5 %; 12 coefficients are fitted.
  EXPECT_NEAR(rms(left.col(0)), kNoise_nm, 0.12 * kNoise_nm);
  EXPECT_NEAR(rms(left.col(1)), kTiltNoise_arcsec, 0.12 * kTiltNoise_arcsec);
  const double correlation = left.col(0).normalized().dot(left.col(1).normalized());
  EXPECT_LT(std::abs(correlation), 0.2);  // four standard errors
}

TEST(CoordinateFrame, TurnsBackIntoTheMotorsDiscrepancy) {
  const Dataset data = measured(2, two_legs);
  const auto problem = lay_out(data, second_degree(data), 4000);
  const auto frame = in_coordinates(*problem);
  ASSERT_TRUE(frame);
  std::vector<std::size_t> all(kRows);
  std::iota(all.begin(), all.end(), std::size_t{0});
  // 7 nm of x at each row: as much in both legs, more or less by the twist.
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(kRows, 2);
  moved.col(0).setConstant(7);
  const Eigen::MatrixXd motors = frame->of_motors(moved, all);
  for (std::size_t i = 0; i < kRows; ++i) {
    const double rx = data.columns[3].values[i];
    EXPECT_NEAR(motors(static_cast<Eigen::Index>(i), 0), 7 * (1 + kTwist * rx), 1e-3);
    EXPECT_NEAR(motors(static_cast<Eigen::Index>(i), 1), 7 * (1 + 0.5 * kTwist * rx), 1e-3);
  }
}

TEST(CoordinateFrame, IsNotTakenWhereEachMotorHasACoordinateOfItsOwn) {
  const Dataset data = measured(3, one_motor_each);
  const auto problem = lay_out(data, second_degree(data), 4000);
  ASSERT_TRUE(problem);
  EXPECT_FALSE(in_coordinates(*problem));
}

// 6 nm in 100 nm of noise: in the frame of the legs nothing is seen of it.
TEST(CoordinateFrame, ShowsAStepOfALengthBehindANoisyTilt) {
  const Dataset data = measured(4, two_legs, 6);
  DiagnoseOptions options;
  options.baseline = second_degree(data);
  options.nulls = 49;
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->findings.size(), 1U);
  const Finding& step = found->findings.front();
  EXPECT_EQ(step.cause, "step_change");
  EXPECT_EQ(step.subject, "x");
  ASSERT_EQ(step.outputs.size(), 2U);
  for (const auto& output : step.outputs) {
    EXPECT_THAT(output.output, testing::AnyOf("q1", "q2"));
    EXPECT_TRUE(output.shown);
    ASSERT_EQ(output.coefficients.size(), 1U);
    // The motor did not move, x reads more; the prior and 0.5 nm of standard error take their part.
    EXPECT_NEAR(1e6 * output.coefficients[0], -6, 1.5);
  }
  ASSERT_EQ(found->outputs.size(), 2U);
  EXPECT_EQ(found->outputs[0].output, "q1");
  EXPECT_NEAR(found->outputs[0].noise_white_sd, 100, 15);  // of the leg: the tilt's
}

TEST(CoordinateFrame, NamesNothingWhereNothingIsHidden) {
  const Dataset data = measured(5, two_legs);
  DiagnoseOptions options;
  options.baseline = second_degree(data);
  options.nulls = 49;
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->findings, testing::IsEmpty());
  EXPECT_EQ(found->verdict, Verdict::adequate);
}

Dataset parallel_robot(const std::string& name) {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/data/parallel/" + name);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  return *formats::read_dataset_csv(text, name);
}

// A play of 1.7 um of one leg, where the rows that learn hardly determine the baseline. One number
// for each coordinate leaves something of it, in the quiet leg q1 too; but q1 has no such finding.
TEST(CoordinateFrame, JudgesAMotorsOwnErrorByThatMotor) {
  const auto found =
      diagnosed(parallel_robot("single_5840008_study.csv"), "q ~ poly(z, rx, ry, 2) + T");
  ASSERT_THAT(names_found(found), testing::ElementsAre("backlash q2"));
  EXPECT_EQ(found.verdict, Verdict::extended);
  ASSERT_EQ(found.findings[0].outputs.size(), 1U);
  EXPECT_EQ(found.findings[0].outputs[0].output, "q2");
  // What is printed of the other legs is what they are given: nothing.
  for (const auto& output : found.outputs)
    if (output.output == "q2")
      EXPECT_LT(*output.a90_validation_after, 0.5 * *output.a90_validation_before);
    else
      EXPECT_NEAR(*output.a90_validation_after, *output.a90_validation_before, 1e-6);
}

// Errors of two coordinates that are alike may cancel in a motor: the motors have the last word.
TEST(CoordinateFrame, OffersNothingThatDescribesAMotorWorse) {
  const auto found =
      diagnosed(parallel_robot("single_5827200_study.csv"), "q ~ poly(x, y, z, 2) + T");
  EXPECT_NE(found.verdict, Verdict::extended);
  EXPECT_THAT(found.warnings, testing::Contains(testing::HasSubstr("described worse (A90 of q2")));
  for (const auto& output : found.outputs)
    EXPECT_LE(*output.a90_validation_after, 1.02 * *output.a90_validation_before) << output.output;
}

}  // namespace
}  // namespace coordinate_frame_test
}  // namespace driftwise::diagnosis
