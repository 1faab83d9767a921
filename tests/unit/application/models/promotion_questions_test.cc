// What a campaign's wanted accuracy asks before its model serves.
#include "server/application/provenance/promotion_questions.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

calibration::Model model_of(double a90_mm, std::int64_t validation_rows) {
  calibration::Model model;
  calibration::OutputModel output;
  output.channel = {"q1", "mm"};
  output.accuracy.a90_calibration = a90_mm;
  output.accuracy.u90_calibration = a90_mm;
  output.accuracy.mean_calibration = 0;
  if (validation_rows > 0) {
    output.accuracy.a90_validation = a90_mm;
    output.accuracy.u90_validation = a90_mm;
    output.accuracy.mean_validation = 0;
  }
  model.outputs = {output};
  model.lineage.rows_calibration = 400;
  model.lineage.rows_validation = validation_rows;
  return model;
}

TEST(CorrectionQuestions, TellTheInstantInUtc) {
  CorrectionRecord taken_back;
  taken_back.id = CorrectionId{7};
  taken_back.ended = CellTime{1'800'000'000'000'000'000};
  taken_back.ended_by = "ada";
  const auto utc = [](CellTime at) { return UtcTime{at.utc_ns - 3'600'000'000'000}; };
  const auto questions = correction_questions({taken_back}, utc);
  ASSERT_THAT(questions, SizeIs(1));
  EXPECT_THAT(questions[0], HasSubstr("took back at 2027-01-15T07:00:00Z"));
}

TEST(CorrectionQuestions, AreNoneWhereTheSameOneIsInForceAgain) {
  CorrectionRecord ended, again;
  ended.id = {3}, again.id = {5};
  ended.diagnosis = again.diagnosis = DiagnosisId{2};
  ended.json = again.json = R"({"shifts":[]})";
  ended.ended = CellTime{100};
  const auto utc = [](CellTime at) { return UtcTime{at.utc_ns}; };
  EXPECT_THAT(correction_questions({ended, again}, utc), IsEmpty());
  again.json = R"({"shifts":[1]})";  // other findings of it
  EXPECT_THAT(correction_questions({ended, again}, utc), SizeIs(1));
}

TEST(AccuracyQuestions, AreNoneWhereNoCampaignStatesWhatItWants) {
  EXPECT_THAT(accuracy_questions(model_of(80e-6, 0), {{{"sample", "A12"}}}), IsEmpty());
}

TEST(AccuracyQuestions, AreNoneWhereItIsReached) {
  EXPECT_THAT(accuracy_questions(model_of(80e-6, 60), {{{"wanted_a90_nm", "100"}}}), IsEmpty());
}

TEST(AccuracyQuestions, NameTheFigureThatMissesTheStrictestOfItsRuns) {
  const auto questions = accuracy_questions(
      model_of(80e-6, 60), {{{"wanted_a90_nm", "100"}}, {{"wanted_a90_nm", "50"}}});
  ASSERT_THAT(questions, SizeIs(1));
  EXPECT_THAT(questions[0], HasSubstr("wants an A90 of 50 nm and it has 80 nm (q1)"));
}

TEST(AccuracyQuestions, NameTheCoordinateWhoseFigureAMotorMayMiss) {
  const auto questions = accuracy_questions(
      model_of(80e-6, 60), {{{"wanted_a90.x_nm", "60"}, {"wanted_a90.z_nm", "200"}}});
  ASSERT_THAT(questions, SizeIs(1));
  EXPECT_THAT(questions[0], HasSubstr("wants an A90 of 60 nm of x and it has 80 nm (q1)"));
}

TEST(AccuracyQuestions, AskForValidationRows) {
  const auto questions = accuracy_questions(model_of(80e-6, 0), {{{"wanted_a90_nm", "100"}}});
  ASSERT_THAT(questions, SizeIs(1));
  EXPECT_THAT(questions[0], HasSubstr("no validation rows"));
}

TEST(ImportedGeometryQuestions, AreAskedOfARobotFileThatNoDataJudged) {
  auto model = model_of(80e-6, 0);
  model.geometry.emplace();
  const auto questions = imported_geometry_questions(model);
  ASSERT_THAT(questions, SizeIs(1));
  EXPECT_THAT(questions[0], HasSubstr("no data judged it"));
  EXPECT_THAT(accuracy_questions(model, {{{"wanted_a90_nm", "100"}}}), IsEmpty());
  model.geometry->covariance = Eigen::MatrixXd::Identity(3, 3);  // identified on data
  EXPECT_THAT(imported_geometry_questions(model), IsEmpty());
}

KinematicsDescription delta() {
  KinematicsDescription robot;
  robot.kind = "delta-vertical";
  for (int i = 0; i < 3; ++i)
    robot.branches.push_back({.motor = {"q" + std::to_string(i + 1), "mm"},
                              .azimuth_deg = 120.0 * i,
                              .radius_mm = 40,
                              .length_mm = 70});
  return robot;
}
KinematicsDescription axis() {
  KinematicsDescription robot;
  robot.kind = "linear-axis";
  robot.axes = {{.motor = {"q1", "mm"}, .pose = {"x", "mm"}}};
  return robot;
}
KinematicsDescription arm() {
  KinematicsDescription robot;
  robot.kind = "serial-arm";
  robot.links = {{.motor = {"q1", "deg"}, .d_mm = 300, .alpha_deg = 90},
                 {.motor = {"q2", "deg"}, .a_mm = 500},
                 {.motor = {"q3", "deg"}, .a_mm = 400}};
  robot.links[1].errors.drift_channel = {"t05", "degC"};
  robot.links[1].errors.drift_arcsec_per_k = 3;
  return robot;
}

struct Robot {
  const char* name;
  KinematicsDescription robot;
  std::vector<std::string> used;
};
class GeometryOf : public testing::TestWithParam<Robot> {};

// The cell file's laser is a part of a geometry that was identified from its lengths, and so is the
// thermometer of a joint.
TEST_P(GeometryOf, IsAskedAboutEveryDeviceThatItWasIdentifiedFrom) {
  const auto& [name, robot, used] = GetParam();
  calibration::Model model;
  model.geometry = calibration::Geometry{robot, {}, Eigen::MatrixXd::Identity(1, 1)};
  EXPECT_THAT(symbols_used(model), testing::UnorderedElementsAreArray(used));
  for (const auto& symbol : used) {
    formats::ConfigurationChange change;
    change.asks = true;
    change.affects = {symbol};
    EXPECT_THAT(configuration_questions(model, {change}), SizeIs(1)) << symbol;
  }
}
INSTANTIATE_TEST_SUITE_P(
    Table, GeometryOf,
    testing::Values(Robot{"Delta", delta(), {"x", "y", "z", "q1", "q2", "q3"}},
                    Robot{"Axis", axis(), {"x", "q1"}},
                    Robot{"Arm", arm(), {"x", "y", "z", "q1", "q2", "q3", "t05"}}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(AccuracyQuestions, KeepUnitsApart) {
  EXPECT_THAT(accuracy_questions(model_of(80e-6, 60), {{{"wanted_a90_arcsec", "1"}}}), IsEmpty());
}

}  // namespace
}  // namespace driftwise::application
