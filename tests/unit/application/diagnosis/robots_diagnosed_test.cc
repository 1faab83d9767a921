// Two robots in one cell: a diagnosis looks at one of them, in the rooms that know one robot only,
// and everything that leaves them has its id.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "server/application/plans/plans.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/model/model_json.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"
#include "tests/unit/application/two_robots.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Knows one cause: the axis bends. It reads "q1" and "x", and says what else it was shown.
Result<dx::Diagnosis> finds_the_bend(const Dataset& data, const dx::DiagnoseOptions& options) {
  const auto bend = *formats::parse_term("x^2");
  const bool known =
      std::ranges::find(options.baseline.terms, bend) != options.baseline.terms.end();
  auto d = diagnosis_with(options.baseline.formula, {});
  dx::OutputSummary q1;
  q1.output = "q1";
  q1.unit = "nm";
  std::vector<double> errors_nm;
  for (std::size_t row = 0; row < data.rows; ++row)
    errors_nm.push_back(1e6 * (data.find("q1")->values[row] - data.find("x")->values[row]));
  const auto figures = error_figures(errors_nm);
  q1.u90_calibration_before = figures.u90;
  q1.a90_calibration_before = figures.a90;
  q1.u90_calibration_after = q1.a90_calibration_after = known ? figures.a90 : 20;
  d.outputs = {q1};
  for (const auto& column : data.columns) d.warnings.push_back("shown " + column.channel.symbol);
  if (known) return d;
  d.verdict = dx::Verdict::extended;
  d.findings = {finding_of("geometry_order", "x", effects::AppliesTo::robot, {"x^2"}, {-1e-4})};
  d.findings[0].sentence = "The geometry needs terms in x.";
  return d;
}

class RobotsDiagnosed : public testing::Test {
 protected:
  RobotsDiagnosed() {
    ma.bend_nm_per_mm2 = 30;
    ma.warming_k_per_h = 0.01;
  }
  application::DiagnosisRequest request_of(RunId run, const std::string& baseline,
                                           const std::string& robot = {}) {
    application::DiagnosisRequest request;
    request.runs = {run};
    request.baseline = baseline;
    request.robot = robot;
    return request;
  }
  Result<application::DiagnosisView> diagnosed(const application::DiagnosisRequest& request) {
    auto begun = cell.await(cell->diagnoses.create(cell.ada, request));
    if (!begun) return begun;
    const auto id = begun->record.id;
    cell.until([&] { return look(id).record.state != JobState::running; });
    return look(id);
  }
  application::DiagnosisView look(DiagnosisId id) { return *cell.await(cell->diagnoses.get(id)); }
  std::string refusal(const application::DiagnosisRequest& request) {
    const auto view = cell.await(cell->diagnoses.create(cell.ada, request));
    return view ? "accepted" : view.error().reason + ": " + view.error().message;
  }

  Folder folder;
  SmallWorld ma, mn;
  CellInMemory cell{two_robot_devices(ma, mn),
                    two_robot_cell(folder / "cell.sqlite"),
                    kSqlite,
                    {.begin = kWorldBegin, .diagnose = finds_the_bend}};
};

const std::string kPlanOfBoth =
    rows_of_both(6, {{-4, 1}, {-2.5, 0.5}, {-1, -1}, {1.5, 1.5}, {2.4, -0.5}, {2, 0.7}});

TEST_F(RobotsDiagnosed, TheOneThatTheBaselineNamesIsLookedAtAndNamed) {
  const auto run = cell.begin_run(kPlanOfBoth);
  cell.finish_run();
  const auto view = diagnosed(request_of(run.id, "ma.q ~ ma.x"));
  ASSERT_TRUE(view) << view.error().message;
  ASSERT_TRUE(view->found) << view->record.reason;
  EXPECT_EQ(view->record.baseline, "ma.q ~ ma.x");
  const auto& found = *view->found;
  EXPECT_EQ(found.outputs[0].output, "ma.q1");
  EXPECT_EQ(found.findings[0].subject, "ma.x");
  EXPECT_EQ(found.findings[0].sentence, "The geometry needs terms in ma.x.");
  EXPECT_THAT(found.warnings, testing::IsSupersetOf({"shown ma.q1", "shown ma.x", "shown mn.q1"}))
      << "the other robot's coordinate stays available";
  EXPECT_THAT(cell.events_named("diagnosis.done").back(), HasSubstr("of robot ma found"));
  // Named by --robot, in the robot's own names: the same.
  const auto named = diagnosed(request_of(run.id, "q ~ x + mn.q1", "ma"));
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->record.baseline, "ma.q ~ ma.x + mn.q1");
  EXPECT_EQ(named->found->outputs[0].output, "ma.q1");
}

TEST_F(RobotsDiagnosed, AcceptingMakesAModelOfThatRobot) {
  const auto run = cell.begin_run(kPlanOfBoth);
  cell.finish_run();
  const auto view = diagnosed(request_of(run.id, "ma.q ~ ma.x"));
  ASSERT_TRUE(view && view->found);
  application::AcceptRequest promoting;
  promoting.diagnosis = view->record.id;
  promoting.promote = true;
  const auto refused = cell.await(cell->extensions.accept(cell.ada, promoting));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("serves within a serving plan"));
  promoting.promote = false;
  const auto made = cell.await(cell->extensions.accept(cell.ada, promoting));
  ASSERT_TRUE(made) << made.error().message;
  const auto model = *formats::read_model_json(cell.await(cell->models.get(*made->model))->json);
  EXPECT_EQ(model.formula, "ma.q ~ ma.x + ma.x^2");
  EXPECT_EQ(model.outputs[0].channel.symbol, "ma.q1");
  EXPECT_LT(model.outputs[0].accuracy.rmse * 1e6, 30) << "nm; 30 nm/mm^2 over 4 mm before";
}

TEST_F(RobotsDiagnosed, AModelThatAPlanServesWithIsUndoneAfterThePlan) {
  const auto run = cell.begin_run(kPlanOfBoth);
  cell.finish_run();
  const auto view = diagnosed(request_of(run.id, "ma.q ~ ma.x"));
  ASSERT_TRUE(view && view->found);
  const auto id = view->record.id;
  const auto made = cell.await(cell->extensions.accept(cell.ada, {id, {}, false}));
  ASSERT_TRUE(made) << made.error().message;
  application::FitRequest fit;
  fit.formula = "mn.q1 ~ mn.x";
  fit.csv = "mn.q1_mm,mn.x_mm\n";
  for (int i = 0; i < 40; ++i)
    fit.csv +=
        fmt::format("{},{}\n", 1.001 * (0.2 * i - 4) + 1e-6 * (i * 7919 % 13 - 6), 0.2 * i - 4);
  const auto of_mn = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(of_mn) << of_mn.error().message;
  const auto plan =
      cell.await(cell->plans.add(cell.ada,
                                 fmt::format("name = \"both\"\n[[robot]]\nid = \"ma\"\nmodel = {}\n"
                                             "[[robot]]\nid = \"mn\"\nmodel = {}\n",
                                             made->model->value, of_mn->id.value),
                                 "", ""));
  ASSERT_TRUE(plan) << plan.error().message;
  const auto promoted = cell.await(cell->plans.promote(cell.ada, plan->id, true));
  ASSERT_TRUE(promoted) << promoted.error().message;
  const auto refused = cell.await(cell->extensions.undo(cell.ada, id));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "EXTENSION_STANDS");
  EXPECT_THAT(refused.error().message, HasSubstr("plan 1 serves with model 1 of diagnosis 1"));
  ASSERT_TRUE(cell.await(cell->plans.roll_back(cell.ada)));
  EXPECT_TRUE(cell.await(cell->extensions.undo(cell.ada, id)));
}

TEST_F(RobotsDiagnosed, AnImprovementMeasuresFindsExtendsAndIsJudgedOnFreshPoints) {
  application::ImproveRequest request;
  request.trajectory_name = "lines.csv";
  request.trajectory_text = kPlanOfBoth;
  request.formula = "q ~ x";
  request.robot = "ma";
  request.lease_token = cell.lease();
  request.promotes = true;
  const auto refused = cell.await(cell->improvements.create(cell.ada, request));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("leave --promote out"));
  request.promotes = false;
  const auto begun = cell.await(cell->improvements.create(cell.ada, request));
  ASSERT_TRUE(begun) << begun.error().message;
  const auto read = [&] {
    return *cell.await(
        cell.read([id = begun->id](Store& store) { return store.improvements().improvement(id); }));
  };
  cell.until([&] { return read().state != JobState::running; }, 400'000);
  const auto record = read();
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_EQ(record.reason, "nothing beyond noise is left");
  EXPECT_EQ(record.formula, "ma.q ~ ma.x");
  ASSERT_EQ(record.turns.size(), 2u);
  ASSERT_EQ(record.turns[0].gains.size(), 1u);
  const auto& gain = record.turns[0].gains[0];
  EXPECT_EQ(gain.output, "ma.q1");
  ASSERT_TRUE(gain.measured && gain.measured_before);
  EXPECT_GT(gain.measured_before->a90, 150);
  EXPECT_LT(gain.measured->a90, 50);
  EXPECT_EQ(
      formats::read_model_json(cell.await(cell->models.get(*record.turns[0].model))->json)->formula,
      "ma.q ~ ma.x + ma.x^2");
}

TEST_F(RobotsDiagnosed, OneThatIsNotNamedOrNotThereIsRefusedWithWhatToDo) {
  const auto run = cell.begin_run(kPlanOfBoth);
  cell.finish_run();
  EXPECT_THAT(refusal(request_of(run.id, "q ~ x")),
              AllOf(HasSubstr("AMBIGUOUS_COORDINATE"), HasSubstr("--robot ma")));
  EXPECT_THAT(refusal(request_of(run.id, "q ~ x", "xy")),
              AllOf(HasSubstr("OTHER_ROBOT"), HasSubstr("their robots are 'ma', 'mn'")));
  EXPECT_THAT(refusal(request_of(run.id, "ma.q ~ ma.x", "mn")), HasSubstr("OTHER_ROBOT"));
  EXPECT_THAT(refusal(request_of(run.id, "ma.q + mn.q ~ t01")), HasSubstr("make one for each"));
  EXPECT_THAT(refusal(request_of(run.id, "mn.q ~ mn.x")),
              AllOf(HasSubstr("UNKNOWN_CHANNEL"), HasSubstr("ma.x")));
  EXPECT_THAT(refusal(request_of(run.id, "", "ma")),
              AllOf(HasSubstr("NO_MODEL"), HasSubstr("--baseline")));
}

}  // namespace
}  // namespace driftwise::tests
