// A diagnosis of one robot of several: the same as of that robot alone, with its id on every name.

#include "server/formats/diagnosis/robot_names.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "server/diagnosis/diagnose.h"
#include "server/formats/diagnosis/diagnosis_json.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/formula/formula.h"

namespace driftwise::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Robot "ma" of one axis that bends by 60 nm/mm^2 and follows t05 by 900 nm/K, beside robot "mn"
// whose axis goes its own way. id: before the names of "ma".
Dataset two_axes(const std::string& id) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise_mm(0, 4e-6);
  std::uniform_real_distribution<double> place_mm(-3, 3);
  Dataset data;
  data.rows = 400;
  std::vector<double> q(data.rows), x(data.rows), other(data.rows), t(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row) {
    data.time_s.push_back(30.0 * static_cast<double>(row));
    data.set.push_back(row % 4 == 3 ? PointSet::validation : PointSet::calibration);
    x[row] = place_mm(random);
    other[row] = place_mm(random);
    t[row] =
        20.5 + 0.4 * std::sin(data.time_s.back() / 2400) + 0.1 * std::cos(data.time_s.back() / 700);
    q[row] = x[row] + 60e-6 * x[row] * x[row] + 900e-6 * (t[row] - 20.5) + noise_mm(random);
  }
  data.columns = {{{id + "q1", "mm"}, q},
                  {{id + "x", "mm"}, x},
                  {{"mn.q1", "mm"}, other},
                  {{"t05", "degC"}, t}};
  return data;
}

diagnosis::Diagnosis diagnosed(const Dataset& data) {
  diagnosis::DiagnoseOptions options;
  options.baseline = *Formula::parse("q ~ x")->expand(data);
  return *diagnosis::diagnose(data, options);
}

TEST(RobotNames, ADiagnosisOfOneRobotOfSeveralIsThatOfTheRobotAlone) {
  const auto alone = diagnosed(two_axes(""));
  const Dataset cell = two_axes("ma.");
  const RobotNames names(cell, "ma");
  const auto found = names.with_id(diagnosed(names.bare(cell)));
  EXPECT_EQ(found.baseline_formula, "ma.q ~ ma.x");
  ASSERT_EQ(found.outputs.size(), 1u);
  EXPECT_EQ(found.outputs[0].output, "ma.q1");
  EXPECT_EQ(found.outputs[0].a90_validation_after, alone.outputs[0].a90_validation_after);
  ASSERT_GE(found.findings.size(), 2u) << "the bend and the expansion";
  ASSERT_EQ(found.findings.size(), alone.findings.size());
  EXPECT_THAT(found.extended_formula, AllOf(HasSubstr("ma.x^2"), HasSubstr("t05")));
  // What extends the simulation is a formula of the cell's data, and its terms read the cell's
  // channels.
  EXPECT_TRUE(Formula::parse(found.extended_formula)->expand(cell)) << found.extended_formula;
  for (const auto& finding : found.findings) {
    EXPECT_THAT(finding.sentence, Not(testing::ContainsRegex("(^| )(q1|x)([ ,;:]|$)")));
    for (const auto& output : finding.outputs) EXPECT_EQ(output.output, "ma.q1");
  }
  const auto kept = read_stored_diagnosis(write_stored_diagnosis(found));
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(diagnosis_json(*kept).at("robot"), "ma");
  EXPECT_FALSE(diagnosis_json(alone).contains("robot"));
  const auto back = names.bare(*kept);
  EXPECT_EQ(back.extended_formula, alone.extended_formula);
  for (std::size_t i = 0; i < alone.findings.size(); ++i) {
    EXPECT_EQ(back.findings[i].sentence, alone.findings[i].sentence);
    EXPECT_EQ(back.findings[i].terms, alone.findings[i].terms);
  }
}

TEST(RobotNames, ReplacesWholeNamesOnly) {
  const Dataset cell = two_axes("ma.");
  const RobotNames names(cell, "ma");
  EXPECT_EQ(names.with_id("q ~ poly(x, 3) + mn.q1:t05 + sin(x, 93000 nm)"),
            "ma.q ~ poly(ma.x, 3) + mn.q1:t05 + sin(ma.x, 93000 nm)");
  EXPECT_EQ(names.with_id("x_mm,q1_mm,set\n0.5,1.25,calibration\n"),
            "ma.x_mm,ma.q1_mm,set\n0.5,1.25,calibration\n");
  EXPECT_EQ(names.with_id("q1's error goes with x."), "ma.q1's error goes with ma.x.");
  EXPECT_EQ(names.with_id("mn.x, ex, x2, dx_mm, maximum"), "mn.x, ex, x2, dx_mm, maximum");
  EXPECT_EQ(names.bare("ma.q ~ ma.x + mn.q1 + gamma.x"), "q ~ x + mn.q1 + gamma.x");
  EXPECT_EQ(RobotNames(cell, "").with_id("q ~ x"), "q ~ x");
}

struct Asked {
  std::string name, formula, robot, says;  // says: the robot, or a part of the refusal
};
class WhichRobot : public testing::TestWithParam<Asked> {};
TEST_P(WhichRobot, IsNamedOrRefused) {
  const auto& a = GetParam();
  Dataset data = two_axes(a.name == "OfACellWithOne" ? "" : "ma.");
  if (a.name == "OfACellWithOne") data.columns.erase(data.columns.begin() + 2);
  const auto robot = robot_asked_for(data, a.formula, a.robot);
  EXPECT_THAT(robot ? *robot : robot.error().message, HasSubstr(a.says));
}
INSTANTIATE_TEST_SUITE_P(
    Table, WhichRobot,
    testing::Values(
        Asked{"ByTheOutputs", "ma.q ~ ma.x", "", "ma"}, Asked{"ByItsId", "q ~ x", "ma", "ma"},
        Asked{"NotNamed", "q ~ x", "", "name the one to look at (--robot ma)"},
        Asked{"NotThere", "q ~ x", "xy", "no channel of robot 'xy'; their robots are 'ma', 'mn'"},
        Asked{"AnotherThanTheOutputs", "ma.q ~ ma.x", "mn", "the baseline is of robot 'ma'"},
        Asked{"TwoAtOnce", "ma.q + mn.q ~ t05", "", "one robot, make one for each"}),
    [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace driftwise::formats
