// An arm of three joints whose points come from trigonometry written out here, with deviations that
// its drawing does not know.

#include "server/diagnosis/robot/robot_diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/diagnosis/robots/finding_names.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Hidden {
  double upper_arm_mm = 0, elbow_deg = 0;  // deviations
  double mm_per_k = 0;                     // in z, with t04
};

// q1 turns the arm about z; shoulder q2 and elbow q3 lift it.
Dataset arm_campaign(const Hidden& hidden, std::uint64_t seed, std::size_t rows = 400) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> turn(-1.2, 1.2), lift(0.2, 1.2), elbow(-1.6, -0.4);
  const double a2 = 600 + hidden.upper_arm_mm, a3 = 500;
  Dataset data;
  data.rows = rows;
  for (const char* name : {"q1_rad", "q2_rad", "q3_rad", "t04_degC", "x_mm", "y_mm", "z_mm"})
    data.columns.push_back({*parse_channel(name), {}});
  double slow = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const double time_s = 10.0 * static_cast<double>(i);
    const double q[3] = {turn(random), lift(random), elbow(random)};
    const double t04 = 20 + 1.5 * std::sin(time_s / 150) + 0.002 * normal(random);
    const double bent = q[1] + q[2] + hidden.elbow_deg * kDegree;
    const double out = a2 * std::cos(q[1]) + a3 * std::cos(bent);
    slow = 0.9 * slow + 0.01 * normal(random);
    const double point[3] = {
        out * std::cos(q[0]), out * std::sin(q[0]),
        120 + a2 * std::sin(q[1]) + a3 * std::sin(bent) + hidden.mm_per_k * (t04 - 20)};
    data.time_s.push_back(time_s);
    for (std::size_t k = 0; k < 3; ++k) data.columns[k].values.push_back(q[k]);
    data.columns[3].values.push_back(t04);
    for (std::size_t k = 0; k < 3; ++k)
      data.columns[4 + k].values.push_back(point[k] + 0.03 * normal(random) + slow);
  }
  return data;
}

std::shared_ptr<const kinematics::Mechanism> arm() {
  KinematicsDescription drawing;
  drawing.kind = "serial-arm";
  drawing.links = {{{"q1", "rad"}, 0, 120, 0, 90, 0},
                   {{"q2", "rad"}, 0, 0, 600, 0, 0},
                   {{"q3", "rad"}, 0, 0, 500, 0, 0}};
  return *kinematics::make_mechanism(drawing);
}

TEST(RobotDiagnosis, NamesTheNumbersOfTheDrawingThatAreWrong) {
  const auto found =
      diagnose_robot(arm_campaign({.upper_arm_mm = 0.4, .elbow_deg = 0.03}, 11), arm(), {});
  ASSERT_TRUE(found) << found.error().message;
  const auto& diagnosis = found->diagnosis;
  // Behind the last joint an offset of its angle and a shift of the tool across the arm are one.
  EXPECT_EQ(names(diagnosis), (Names{"geometry_parameter link2.a", "geometry_parameter tool.y"}));
  EXPECT_EQ(diagnosis.verdict, Verdict::extended);
  const double shift_mm = 0.03 * kDegree * 500;
  for (const auto& finding : diagnosis.findings) {
    const bool arm = finding.subject == "link2.a";
    EXPECT_EQ(finding.indistinguishable_from,
              arm ? Names{} : Names{"geometry_parameter link3.theta"});
    const auto& value = finding.parameters.front();
    const double reach = value.ci90->high - value.value;
    EXPECT_NEAR(value.value, arm ? 600.4 : shift_mm, 2.5 * reach) << finding.sentence;
    ASSERT_TRUE(finding.outputs.front().u90_before);
    EXPECT_LT(*finding.outputs.front().u90_after, *finding.outputs.front().u90_before);
  }
  EXPECT_NEAR(found->robot.links[1].a_mm, 600.4, 0.02);
  EXPECT_NEAR(found->robot.tool_y_mm, shift_mm, 0.02);
  // and so is the next diagnosis' drawing: nothing of it is wrong any more
  const auto again = diagnose_robot(arm_campaign({.upper_arm_mm = 0.4, .elbow_deg = 0.03}, 11),
                                    *kinematics::make_mechanism(found->robot), {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(names(again->diagnosis), Names{});
}

TEST(RobotDiagnosis, NamesNothingOfARobotThatIsAsDrawn) {
  int named = 0;
  for (std::uint64_t seed = 100; seed < 108; ++seed) {
    const auto found = diagnose_robot(arm_campaign({}, seed, 200), arm(), {});
    ASSERT_TRUE(found) << found.error().message;
    named += found->diagnosis.findings.empty() ? 0 : 1;
  }
  EXPECT_EQ(named, 0);  // of 8: nominal rate 0.3 % for each look, two looks
}

TEST(RobotDiagnosis, LooksForOtherCausesBeyondTheDrawing) {
  const auto found =
      diagnose_robot(arm_campaign({.upper_arm_mm = 0.4, .mm_per_k = 0.05}, 12), arm(), {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(names(found->diagnosis), (Names{"geometry_parameter link2.a", "thermal_offset t04"}));
}

// A campaign whose elbow stood still: what it hides, the next one is asked again.
TEST(RobotDiagnosis, HoldsForGoodOnlyWhatEveryPostureHides) {
  const auto moving = diagnose_robot(arm_campaign({.upper_arm_mm = 0.4}, 13), arm(), {});
  auto still = arm_campaign({}, 13);
  for (std::size_t row = 0; row < still.rows; ++row) {
    const double q1 = still.columns[0].values[row], q2 = still.columns[1].values[row];
    const double out = 600.4 * std::cos(q2) + 500 * std::cos(q2 - 1);
    still.columns[2].values[row] = -1;
    still.columns[4].values[row] = out * std::cos(q1);
    still.columns[5].values[row] = out * std::sin(q1);
    still.columns[6].values[row] = 120 + 600.4 * std::sin(q2) + 500 * std::sin(q2 - 1);
  }
  std::mt19937_64 random(14);
  std::normal_distribution<double> noise_mm(0, 0.03);
  for (std::size_t column = 4; column < 7; ++column)
    for (double& value : still.columns[column].values) value += noise_mm(random);
  const auto stood = diagnose_robot(still, arm(), {});
  ASSERT_TRUE(moving) << moving.error().message;
  ASSERT_TRUE(stood) << stood.error().message;
  EXPECT_EQ(stood->robot.hold, moving->robot.hold);
  EXPECT_FALSE(moving->robot.hold.empty());
  bool told = false;
  for (const auto& one : stood->diagnosis.not_testable)
    told = told ||
           (one.cause == "gear_error joint3" && one.why == "the joint did not turn in these rows");
  EXPECT_TRUE(told);
}

std::string contents(const std::string& path) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/" + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(RobotDiagnosis, OfTheRealUr10FindsTheArmsAsLongAsRDoes) {
  const auto data =
      formats::read_dataset_csv(contents("ur10_laser_tracker/series_a_subset.csv"), "subset");
  const auto robot = kinematics::make_mechanism(
      *formats::parse_robot_file(contents("robots/ur10.toml"), "ur10.toml"));
  const auto found = diagnose_robot(*data, *robot, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->diagnosis.verdict, Verdict::unexplained);  // visits agree better than the model
  int arms = 0;
  for (const auto& finding : found->diagnosis.findings)
    for (const auto& [subject, by_r] :
         {std::pair("link2.a", -613.107), std::pair("link3.a", -571.810)})
      if (finding.subject == subject) {
        ++arms;
        // R's arm does not sag: a length of the upper arm takes up a part of it there.
        EXPECT_NEAR(finding.parameters.front().value, by_r, 0.5) << finding.sentence;
      }
  EXPECT_EQ(arms, 2);
  for (const auto& output : found->diagnosis.outputs) {
    ASSERT_TRUE(output.u90_validation_before && output.u90_validation_after);
    EXPECT_LT(*output.u90_validation_after, *output.u90_validation_before) << output.output;
  }
}

TEST(RobotDiagnosis, RefusesABaselineOfOtherOutputs) {
  DiagnoseOptions options;
  options.baseline.outputs = {"q1"};
  const auto found = diagnose_robot(arm_campaign({}, 1, 50), arm(), options);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "OTHER_OUTPUTS");
}

}  // namespace
}  // namespace driftwise::diagnosis
