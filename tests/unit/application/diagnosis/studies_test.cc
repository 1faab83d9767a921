// Studies of a stored run: the same figures as the engine gives, told as they go, ended when nobody
// wants them any more.

#include "server/application/analyses/studies.h"

#include <gmock/gmock.h>

#include "server/application/plumbing/fit_threads.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using application::Study;
using application::StudyProgress;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

const std::string kWalk = lines_of(8, {-4, -2.5, -1, 0.5, 2, 3.5}, true);
const std::string kAxis =
    "[kinematics]\nkind = \"linear-axis\"\n[[kinematics.axis]]\nmotor = \"q1_mm\"\npose = "
    "\"x_mm\"\n";

class StudiesTest : public testing::Test {
 protected:
  // With a thread of its own the work waits until let_diagnoses_run().
  explicit StudiesTest(bool waits = false)
      : d([](const Dataset&, const dx::DiagnoseOptions&) { return dx::Diagnosis{}; }, waits),
        run(d.measured(kWalk)) {}

  std::shared_ptr<Study> a_study() {
    return std::make_shared<Study>(
        [this](const StudyProgress& progress) { told.push_back(progress); });
  }
  application::FitRequest fit_of(const std::string& formula) const {
    application::FitRequest fit;
    fit.runs = {run};
    fit.formula = formula;
    fit.blocks = 4;
    return fit;
  }
  Dataset data() {
    return d.cell.await(d.cell->models.residuals(stored_model(), {}, "")).value().data;
  }
  ModelId stored_model() {
    return d.cell.await(d.cell->models.fit(d.cell.ada, fit_of("q ~ x"))).value().id;
  }

  DiagnosedCell d;
  RunId run;
  std::vector<StudyProgress> told;
};

class StudiesElsewhereTest : public StudiesTest {
 protected:
  StudiesElsewhereTest() : StudiesTest(true) {}
};

TEST_F(StudiesTest, MethodsOfARunAreThoseOfItsRows) {
  application::MethodsRequest asked{
      .fit = fit_of("q ~ x + T"), .methods = {}, .robot = kAxis, .together = "", .folds = 10};
  const auto judged = d.cell.await(d.cell->studies.compare_methods(asked, a_study()));
  ASSERT_TRUE(judged) << judged.error().message;
  ASSERT_THAT(*judged, SizeIs(4)) << "all that a formula and a geometry allow";
  EXPECT_EQ(told.front().step, "waiting for its turn");
  EXPECT_THAT(told.back().step, HasSubstr("4 of 4"));

  const Dataset rows = data();
  identification::MethodOptions options;
  options.fit.blocks = 4;
  options.fit.candidates = formats::Formula::parse("q ~ x + T")->expand(rows).value();
  identification::JudgeOptions judge;
  judge.blocks = 4;
  const auto alone =
      identification::judge_method(rows, identification::Method::stepwise, options, judge);
  ASSERT_TRUE(alone);
  const auto& here = judged->back();
  EXPECT_EQ(here.fitted.method, identification::Method::stepwise);
  EXPECT_EQ(here.outputs[0].u90_calibration, alone->outputs[0].u90_calibration);
  EXPECT_EQ(here.outputs[0].blocks->figures, alone->outputs[0].blocks->figures);
}

TEST_F(StudiesTest, AsksForAFormulaOrAGeometry) {
  application::MethodsRequest nothing{
      .fit = fit_of(""), .methods = {}, .robot = "", .together = "", .folds = 10};
  EXPECT_EQ(d.cell.await(d.cell->studies.compare_methods(nothing, a_study())).error().reason,
            "NO_METHOD");
  nothing.methods = {"guess"};
  EXPECT_EQ(d.cell.await(d.cell->studies.compare_methods(nothing, a_study())).error().reason,
            "BAD_METHOD");
  nothing.robot = "[kinematics]\nkind = \"spider\"\n";
  EXPECT_EQ(d.cell.await(d.cell->studies.compare_methods(nothing, a_study())).error().reason,
            "UNKNOWN_KIND");
}

TEST_F(StudiesTest, EverySetOfThermometersIsTriedWhateverTheNumberOfThreads) {
  application::SensorsRequest asked{.fit = fit_of("q ~ x + T"), .tolerance = 0.1};
  const auto one = d.cell.await(d.cell->studies.study_sensors(asked, a_study()));
  ASSERT_TRUE(one) << one.error().message;
  EXPECT_EQ(one->unit, "mm");
  EXPECT_GE(one->study.sets_tried, 8u);
  EXPECT_EQ(one->study.sets_tried, std::size_t{1} << (one->study.best.size() - 1));
  double before = 0;
  for (const auto& progress : told) {
    EXPECT_GE(progress.fraction, before);
    before = progress.fraction;
  }
  asked.fit.threads = 4;
  const auto four = d.cell.await(d.cell->studies.study_sensors(asked, a_study()));
  ASSERT_TRUE(four);
  for (std::size_t i = 0; i < one->study.best.size(); ++i) {
    EXPECT_EQ(four->study.best[i].sensors, one->study.best[i].sensors);
    EXPECT_EQ(four->study.best[i].u90_blocks_rms, one->study.best[i].u90_blocks_rms);
  }
}

TEST_F(StudiesTest, ARefusalOfTheEngineIsTheAnswer) {
  application::SensorsRequest asked{.fit = fit_of("q ~ x"), .tolerance = 0.1};
  EXPECT_EQ(d.cell.await(d.cell->studies.study_sensors(asked, a_study())).error().reason,
            "NO_SENSORS");
}

TEST_F(StudiesElsewhereTest, AStoppedOneDoesNoWorkAndAFitDoesNotWaitForIt) {
  application::SensorsRequest asked{.fit = fit_of("q ~ x + T"), .tolerance = 0.1};
  const auto study = a_study();
  std::optional<Result<application::SensorChoice>> answer;
  d.cell.begin(d.cell->studies.study_sensors(asked, study), answer);
  d.cell.until([&] { return !told.empty(); });
  EXPECT_TRUE(d.cell.await(d.cell->models.fit(d.cell.ada, fit_of("q ~ x + x^2"))));
  EXPECT_FALSE(answer);
  study->stop();
  d.let_diagnoses_run();
  d.cell.until([&] { return answer.has_value(); });
  EXPECT_EQ(answer->error().code, ErrorCode::cancelled);
  EXPECT_THAT(told, SizeIs(1)) << "nothing is said to who has left";
}

TEST_F(StudiesElsewhereTest, RefusesANinthAtOnce) {
  application::SensorsRequest asked{.fit = fit_of("q ~ x + T"), .tolerance = 0.1};
  std::vector<std::shared_ptr<Study>> studies;
  std::vector<std::optional<Result<application::SensorChoice>>> answers(8);
  for (auto& answer : answers) {
    studies.push_back(a_study());
    d.cell.begin(d.cell->studies.study_sensors(asked, studies.back()), answer);
  }
  d.cell.until([&] { return told.size() == 8; });
  const auto ninth = d.cell.await(d.cell->studies.study_sensors(asked, a_study()));
  EXPECT_EQ(ninth.error().reason, "TOO_MANY_STUDIES");
  for (const auto& study : studies) study->stop();
  d.let_diagnoses_run();
  d.cell.until([&] {
    return std::ranges::all_of(answers, [](const auto& answer) { return answer.has_value(); });
  });
}

TEST(FitThreads, AJobsExceptionComesHereWhenAllAreDone) {
  const auto executor = application::fit_threads(2);
  if (!executor) GTEST_SKIP() << "one processor";
  EXPECT_THROW(executor(100,
                        [](std::size_t i) {
                          if (i == 50) throw std::runtime_error("fifty");
                        }),
               std::runtime_error);
  std::atomic<int> done = 0;
  executor(100, [&](std::size_t) { ++done; });
  EXPECT_EQ(done, 100);
  executor(0, [&](std::size_t) { ++done; });
  EXPECT_EQ(done, 100);
}

}  // namespace
}  // namespace driftwise::tests
