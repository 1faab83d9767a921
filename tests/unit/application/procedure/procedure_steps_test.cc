// The steps of the procedure, from what a record may hold.
#include <gmock/gmock.h>

#include "server/application/ports/run_plan.h"
#include "server/application/procedure/procedures.h"

namespace driftwise::application {
namespace {

using testing::HasSubstr;
using State = ProcedureStep::State;

ProcedureFacts reached() {
  ProcedureFacts facts;
  facts.sources = {{"geometry (lengths)", "x_mm"}, {"process force", ""}};
  facts.runs = {{.id = 3, .done = true, .compensated = true, .points = 90},
                {.id = 1, .setup = "first", .done = true, .points = 400}};
  facts.campaign = 1;
  facts.wanted = {{"", "nm", 50}};
  facts.model = ProcedureFacts::Model{.id = 2,
                                      .serving = true,
                                      .validation_rows = 60,
                                      .accuracy = {{"q1", "nm", 40}},
                                      .largest_line = "residual",
                                      .largest_u_nm = 20,
                                      .largest_is_measured = true};
  facts.verified_run = 3;
  facts.verified = {{"x", "nm", 45}};
  return facts;
}

TEST(ProcedureSteps, OfAnEmptyRecordNameTheFirstCommandOfEach) {
  const auto steps = procedure_steps({});
  ASSERT_EQ(steps.size(), 6u);
  for (const auto& step : steps) EXPECT_EQ(step.state, State::open) << step.name;
  EXPECT_THAT(steps[1].command, HasSubstr("wanted_a90.x_nm"));
  EXPECT_THAT(steps[2].command, HasSubstr("run start"));
  EXPECT_THAT(steps[3].command, HasSubstr("model grow"));
  EXPECT_THAT(steps[4].command, HasSubstr("--compensate"));
}

TEST(ProcedureSteps, AreDoneWhenTheWantedAccuracyWasMeasuredInPoseCoordinates) {
  const auto steps = procedure_steps(reached());
  for (const auto& step : steps) EXPECT_EQ(step.state, State::done) << step.name;
  EXPECT_THAT(steps[0].missing, HasSubstr("process force"));
  EXPECT_THAT(steps[2].found, HasSubstr("400 points in 1 run, 1 set-up"));
}

TEST(ProcedureSteps, GoBackToTheModelWhenItIsNotGoodEnough) {
  auto facts = reached();
  facts.verified = {{"x", "nm", 80}};
  facts.model->accuracy = {{"q1", "nm", 75}};
  const auto last = procedure_steps(facts).back();
  EXPECT_EQ(last.state, State::not_reached);
  EXPECT_THAT(last.missing, HasSubstr("back to step 3"));
  EXPECT_THAT(last.missing, HasSubstr("residual 20.0 nm"));
  EXPECT_THAT(last.command, HasSubstr("model grow"));
}

TEST(ProcedureSteps, GoBackToTheInstrumentsWhenOneMakesTheLargestLine) {
  auto facts = reached();
  facts.verified = {{"x", "nm", 80}};
  facts.model->largest_line = "beam offset";
  facts.model->largest_u_nm = 44;
  facts.model->largest_is_measured = false;
  facts.model->combined_u_nm = 48;
  const auto last = procedure_steps(facts).back();
  EXPECT_THAT(last.missing, HasSubstr("back to step 0"));
  EXPECT_EQ(last.back_to, 0);
  EXPECT_EQ(last.largest_line, "beam offset");
  EXPECT_EQ(last.largest_u_nm, 44);
}

// 8.6 nm of a laser do not make 49.6 nm: nobody is sent to buy another one.
TEST(ProcedureSteps, DoNotBlameAnInstrumentForMoreThanTheBudgetStates) {
  auto facts = reached();
  facts.wanted = {{"", "nm", 5}};
  facts.verified = {{"x", "nm", 49.6}};
  facts.model->largest_line = "laser";
  facts.model->largest_u_nm = 8.6;
  facts.model->largest_is_measured = false;
  facts.model->combined_u_nm = 10;
  facts.model->accuracy = {{"q1", "nm", 4.8}};
  EXPECT_EQ(procedure_steps(facts).back().back_to, 2);
  facts.model->accuracy = {{"q1", "nm", 159.5}};
  EXPECT_EQ(procedure_steps(facts).back().back_to, 3);
}

TEST(ProcedureSteps, AskForValidationRows) {
  auto facts = reached();
  facts.model->validation_rows = 0;
  const auto steps = procedure_steps(facts);
  EXPECT_EQ(steps[3].state, State::open);
  EXPECT_THAT(steps[3].missing, HasSubstr("no validation rows"));
}

TEST(ProcedureSteps, SayRecalibrateNowOfAModelThatTheRobotNoLongerFollows) {
  auto facts = reached();
  facts.model->doubt = "run 4: q1 errs by +58.2 nm, limit 51.9";
  const auto steps = procedure_steps(facts);
  EXPECT_EQ(steps[3].state, State::open);
  EXPECT_THAT(steps[3].missing, HasSubstr("recalibrate now"));
  EXPECT_THAT(steps[3].missing, HasSubstr("run 4: q1 errs by +58.2 nm"));
  EXPECT_THAT(steps[3].command, HasSubstr("model check"));
  EXPECT_EQ(steps[5].state, State::not_reached) << "what was reached, was reached before";
  EXPECT_EQ(steps[5].back_to, 2);
}

TEST(ProcedureSteps, CompareOnlyFiguresOfOneUnit) {
  auto facts = reached();
  facts.verified.push_back({"rx", "arcsec", 900});
  EXPECT_EQ(procedure_steps(facts).back().state, State::done);
  facts.wanted.push_back({"", "arcsec", 5});
  EXPECT_EQ(procedure_steps(facts).back().state, State::not_reached);
}

TEST(ProcedureSteps, JudgeEachCoordinateByItsOwnFigure) {
  auto facts = reached();
  facts.verified = {{"x", "nm", 45}, {"z", "nm", 120}};
  EXPECT_THAT(procedure_steps(facts).back().found, HasSubstr("z 120.0 nm, wanted 50"));
  facts.wanted = {{"", "nm", 50}, {"z", "nm", 150}};
  const auto last = procedure_steps(facts).back();
  EXPECT_EQ(last.state, State::done);
  ASSERT_EQ(last.figures.size(), 2u);
  EXPECT_EQ(last.figures[1].wanted, 150);
}

TEST(ProcedureSteps, DoNotCallAWantedCoordinateReachedThatNobodyMeasured) {
  auto facts = reached();
  facts.wanted = {{"x", "nm", 50}, {"rz", "arcsec", 1}};
  const auto last = procedure_steps(facts).back();
  EXPECT_EQ(last.state, State::open);
  EXPECT_THAT(last.missing, HasSubstr("measured nothing of: rz 1 arcsec"));
}

TEST(ProcedureSteps, SayWhyTheLastCompensatedRunCannotBeJudged) {
  auto facts = reached();
  facts.verified.clear();
  facts.not_verified = "too few rows";
  const auto steps = procedure_steps(facts);
  EXPECT_EQ(steps[4].state, State::open);
  EXPECT_THAT(steps[4].missing, HasSubstr("run 3 cannot be judged: too few rows"));
  EXPECT_EQ(steps[5].state, State::open);
}

TEST(ProcedureSteps, NameAStatementThatSaysNothing) {
  auto facts = reached();
  facts.wanted.clear();
  facts.campaign.reset();
  facts.unreadable = {"run 1: expected a number above 0"};
  const auto step = procedure_steps(facts)[1];
  EXPECT_EQ(step.state, State::open);
  EXPECT_THAT(step.missing, HasSubstr("expected a number above 0"));
}

RunRecord run_of(std::int64_t id, bool compensated, RunMetadata metadata) {
  RunRecord run;
  run.id = {id};
  run.state = RunState::done;
  run.accepted = 100 * id;
  run.config_hash = "c0ffee";
  RunPlan plan;
  plan.compensate = compensated;
  run.rules_json = write_run_plan(plan);
  run.metadata = std::move(metadata);
  return run;
}

TEST(ProcedureFacts, AreOfTheNewestRunThatStatesAWantedAccuracy) {
  ProcedureFacts facts;
  take_runs({run_of(4, true, {{"sample", "A12"}}),
             run_of(3, false, {{"wanted_a90.x_nm", "80"}, {"wanted_a90_arcsec", "2"}}),
             run_of(2, false, {{"wanted_a90_nm", "500"}})},
            facts);
  EXPECT_EQ(facts.verified_run, 4);
  EXPECT_EQ(facts.campaign, 3);
  EXPECT_EQ(wanted_text(facts.wanted), "x 80 nm, every rotation 2 arcsec");
  EXPECT_EQ(facts.runs.size(), 3u);
}

TEST(ProcedureFacts, HaveNothingOfARunWhoseRowsAreAFiles) {
  auto stranger = run_of(8, false, {{"wanted_a90.x_nm", "80"}});
  stranger.config_hash.clear();
  stranger.reason = "imported";
  auto join = run_of(5, false, {});
  join.reason = "imported";  // of runs 2 and 3
  ProcedureFacts facts;
  take_runs({stranger, join, run_of(3, false, {}), run_of(2, false, {})}, facts);
  EXPECT_FALSE(facts.campaign);
  const auto steps = procedure_steps(facts);
  EXPECT_THAT(steps[1].command, HasSubstr("run tag 5 "));
  EXPECT_THAT(steps[2].found, HasSubstr("500 points in 2 runs")) << "each point once";
}

TEST(ProcedureFacts, SayWhatAnOldRecordStatesBadly) {
  ProcedureFacts facts;
  take_runs({run_of(3, false, {{"wanted_a90_nm", "soon"}})}, facts);
  EXPECT_FALSE(facts.campaign);
  ASSERT_EQ(facts.unreadable.size(), 1u);
  EXPECT_THAT(facts.unreadable[0], HasSubstr("run 3"));
}

TEST(SourcesOfInaccuracy, AreMeasuredByTheChannelsOfTheCell) {
  CellDescription cell;
  DeviceDescription laser, scanner;
  laser.become<LengthSettings>().channel = {"x", "mm"};
  auto& probes = scanner.become<TemperatureSettings>().probes;
  probes.resize(2);
  probes[0].channel = {"t04", "degC"};
  probes[0].part = "robot";
  probes[1].channel = {"t01", "degC"};
  probes[1].part = "instrument";
  laser.id = "laser-x";
  cell.devices = {laser, scanner};
  LatestValue level, air;
  level.device = air.device = "laser-x";
  level.channel = {"level_x", "pct"};
  air.channel = {"air_x", "degC"};
  const auto by = [sources = sources_of(cell, {level, air})](const std::string& name) {
    for (const auto& source : sources)
      if (source.name == name) return source.measured_by;
    return std::string("no such source");
  };
  EXPECT_EQ(by("geometry (lengths)"), "x_mm");
  EXPECT_EQ(by("temperatures of the robot"), "t04_degC");
  EXPECT_EQ(by("temperatures of the instruments"), "t01_degC");
  EXPECT_EQ(by("temperature of the air"), "air_x_degC") << "the interferometer's own probe";
  EXPECT_EQ(by("parasitic rotations"), "");
  EXPECT_EQ(by("process force"), "");
  cell.load.emplace();
  const auto with_load = sources_of(cell, {});
  EXPECT_EQ(with_load.back().measured_by, "force_N");
}

}  // namespace
}  // namespace driftwise::application
