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

TEST(AccuracyQuestions, KeepUnitsApart) {
  EXPECT_THAT(accuracy_questions(model_of(80e-6, 60), {{{"wanted_a90_arcsec", "1"}}}), IsEmpty());
}

}  // namespace
}  // namespace driftwise::application
