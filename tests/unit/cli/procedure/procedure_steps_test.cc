// The steps of the procedure, from what a record may hold.
#include "clients/cli/commands/procedure/procedure_steps.h"

#include <gmock/gmock.h>

namespace driftwise::cli {
namespace {

using testing::HasSubstr;

ProcedureFacts reached() {
  ProcedureFacts facts;
  facts.sources = {{"geometry (lengths)", true}, {"process force", false}};
  facts.runs = {{.id = 3, .done = true, .compensated = true, .points = 90},
                {.id = 1, .setup = "first", .done = true, .points = 400}};
  facts.campaign = 1;
  facts.wanted = {{"nm", 50}};
  facts.model = ProcedureFacts::Model{.id = 2,
                                      .serving = true,
                                      .validation_rows = 60,
                                      .accuracy = {{"q1", "nm", 40}},
                                      .largest_line = "residual 20.0 nm",
                                      .largest_is_measured = true};
  facts.verified_run = 3;
  facts.verified = {{"x", "nm", 45}};
  return facts;
}

TEST(ProcedureSteps, OfAnEmptyRecordNameTheFirstCommandOfEach) {
  const auto steps = procedure_steps({});
  ASSERT_EQ(steps.size(), 6u);
  for (const auto& step : steps) EXPECT_EQ(step.state, "open") << step.name;
  EXPECT_THAT(steps[1].command, HasSubstr("wanted_a90_nm"));
  EXPECT_THAT(steps[2].command, HasSubstr("run start"));
  EXPECT_THAT(steps[3].command, HasSubstr("model grow"));
  EXPECT_THAT(steps[4].command, HasSubstr("--compensate"));
}

TEST(ProcedureSteps, AreDoneWhenTheWantedAccuracyWasMeasuredInPoseCoordinates) {
  const auto steps = procedure_steps(reached());
  for (const auto& step : steps) EXPECT_EQ(step.state, "done") << step.name;
  EXPECT_THAT(steps[0].missing, HasSubstr("process force"));
  EXPECT_THAT(steps[2].found, HasSubstr("400 points in 1 run, 1 set-ups"));
}

TEST(ProcedureSteps, GoBackToTheModelWhenItIsNotGoodEnough) {
  auto facts = reached();
  facts.verified = {{"x", "nm", 80}};
  facts.model->accuracy = {{"q1", "nm", 75}};
  const auto last = procedure_steps(facts).back();
  EXPECT_EQ(last.state, "not reached");
  EXPECT_THAT(last.missing, HasSubstr("back to step 3"));
  EXPECT_THAT(last.missing, HasSubstr("residual 20.0 nm"));
  EXPECT_THAT(last.command, HasSubstr("model grow"));
}

TEST(ProcedureSteps, GoBackToTheInstrumentsWhenOneMakesTheLargestLine) {
  auto facts = reached();
  facts.verified = {{"x", "nm", 80}};
  facts.model->largest_line = "beam offset 44.0 nm";
  facts.model->largest_is_measured = false;
  EXPECT_THAT(procedure_steps(facts).back().missing, HasSubstr("back to step 0"));
}

TEST(ProcedureSteps, AskForValidationRows) {
  auto facts = reached();
  facts.model->validation_rows = 0;
  const auto steps = procedure_steps(facts);
  EXPECT_EQ(steps[3].state, "open");
  EXPECT_THAT(steps[3].missing, HasSubstr("no validation rows"));
}

TEST(ProcedureSteps, CompareOnlyFiguresOfOneUnit) {
  auto facts = reached();
  facts.verified.push_back({"rx", "arcsec", 900});
  EXPECT_EQ(procedure_steps(facts).back().state, "done");
  facts.wanted.push_back({"arcsec", 5});
  EXPECT_EQ(procedure_steps(facts).back().state, "not reached");
}

}  // namespace
}  // namespace driftwise::cli
