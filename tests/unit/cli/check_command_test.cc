// `model check`: a table, a chart, an exit code. And a daemon's fit with all a file's fit has.

#include "clients/cli/commands/models/check_command.h"

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class CheckCommand : public CliTest {
 protected:
  CheckCommand() {
    fakes.checks = &checks;
    fakes.models = &models;
    cell.add_model("q1 ~ x");
    cell.on_executor([this] {
      checks.runs.emplace_back().id = RunId{1};
      auto& report = checks.report;
      diagnosis::OutputCheck output{{"q1", "mm"}, "nm", {12.3, 14, 0.4, "blocks of time"}, {}};
      diagnosis::CheckPoint good, blind;
      good.run = RunId{1};
      good.rows = 100;
      good.judged = true;
      good.bias = -4.2;
      good.bias_limit = 41.0;
      good.sd = 13.5;
      good.sd_limit = 30;
      good.u90 = 22.2;
      blind.run = RunId{2};
      blind.why_not = "the model needs channel 't02'";
      output.points = {good, blind};
      report.outputs = {output};
      report.verdict = diagnosis::CheckVerdict::in_control;
    });
  }
  FakeModelChecks checks;
  FakeModels models{cell};
};

TEST_F(CheckCommand, ShowsEveryRunOnItsChart) {
  const auto said = run({"model", "check", "1"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("model 1: in control: the robot still does what the model says"));
  EXPECT_THAT(said.out, HasSubstr("q1_mm  reference sd 12.3 nm (blocks of time, 14 degrees"));
  EXPECT_THAT(said.out, HasSubstr("-4.2 (+-41.0)"));
  EXPECT_THAT(said.out, HasSubstr("|.........o+..........|"));
  EXPECT_THAT(said.out, HasSubstr("13.5 (30.0)"));
  EXPECT_THAT(said.out, HasSubstr("not judged: the model needs channel 't02'"));
}

TEST_F(CheckCommand, SaysNoWithItsExitCode) {
  cell.on_executor([this] {
    checks.report.verdict = diagnosis::CheckVerdict::recalibrate;
    checks.report.reasons = {"run 1: q1 errs by +83.0 nm on average, limit 41.0"};
  });
  const auto said = run({"model", "check", "1", "--runs", "1"});
  EXPECT_EQ(said.exit, 1);
  EXPECT_THAT(said.out, HasSubstr("model 1: recalibrate now\n  run 1: q1 errs by +83.0 nm"));
  const auto outcome = run({"model", "check", "1", "--json"});
  EXPECT_EQ(outcome.exit, 1);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["verdict"], "recalibrate");
  EXPECT_EQ(json["outputs"][0]["runs"][0]["bias_limit"], 41.0);
  EXPECT_TRUE(json["outputs"][0]["runs"][0]["ewma_bias"].is_null());
}

TEST_F(CheckCommand, ARollbackToADoubtfulModelSaysSo) {
  cell.add_model("q1 ~ x + x^2");
  for (const char* model : {"1", "2"})
    ASSERT_EQ(run({"model", "promote", model, "--yes"}).exit, 0) << model;
  const auto in_control = run({"model", "rollback"});
  EXPECT_THAT(in_control.err, HasSubstr("model 1 serves again"));
  EXPECT_THAT(in_control.err, testing::Not(HasSubstr("the robot no longer does")));
  cell.on_executor([this] {
    checks.report.verdict = diagnosis::CheckVerdict::recalibrate;
    checks.report.reasons = {"run 1: q1 errs by +83.0 nm on average, limit 41.0"};
  });
  EXPECT_THAT(run({"model", "rollback"}).err,
              HasSubstr("the robot no longer does what model 1 says (model check 1): run 1: q1 "
                        "errs by +83.0 nm on average"));
}

TEST_F(CheckCommand, NothingJudgedIsNoGoodNews) {
  cell.on_executor([this] {
    checks.report.verdict = diagnosis::CheckVerdict::not_judged;
    checks.report.outputs.clear();
  });
  const auto said = run({"model", "check", "1"});
  EXPECT_EQ(said.exit, 5);
  EXPECT_THAT(said.out, HasSubstr("not judged: no run since it was made has enough points"));
  EXPECT_EQ(run({"model", "check", "1", "--json"}).exit, 5);
}

TEST_F(CheckCommand, WithoutAServingModelAsksForOne) {
  const auto said = run({"model", "check"});
  EXPECT_EQ(said.exit, 5);
  EXPECT_THAT(said.err, HasSubstr("no model serves"));
}

TEST(ChartLine, MarksWhereTheValueStands) {
  EXPECT_EQ(cli::chart_line(0, 10), "|..........o..........|");
  EXPECT_EQ(cli::chart_line(10, 10), "|..........+.........o|");
  EXPECT_EQ(cli::chart_line(-99, 10), "|X.........+..........|");
  EXPECT_EQ(cli::chart_line(1, 0), "|..........X..........|");
}

TEST_F(CheckCommand, AFitOfARunTakesWhatAFitOfAFileTakes) {
  const auto said = run({"fit",         "--run",     "1",           "--model",  "q1 ~ x + x^2",
                         "--criterion", "bic",       "--hierarchy", "--starts", "3",
                         "--seed",      "7",         "--force",     "t07",      "--without",
                         "x^2",         "--weights", "w",           "--blocks", "5"});
  EXPECT_EQ(said.exit, 0) << said.err;
  const auto fit = cell.on_executor([this] { return models.last_fit; });
  EXPECT_EQ(fit.criterion, "bic");
  EXPECT_TRUE(fit.hierarchy);
  EXPECT_EQ(fit.starts, 3);
  EXPECT_EQ(fit.seed, 7);
  EXPECT_EQ(fit.force_terms, std::vector<std::string>{"t07"});
  EXPECT_EQ(fit.without_terms, std::vector<std::string>{"x^2"});
  EXPECT_EQ(fit.weight_symbol, "w");
  EXPECT_EQ(fit.blocks, 5);
  EXPECT_EQ(run({"fit", "--run", "1", "--model", "q1 ~ x", "--exclude-rows", "3"}).exit, 2);
}

// Of a fit without blocks of time.
TEST_F(CheckCommand, ShowsOnlyTheHeldOutRowsThatAnOfferHas) {
  cell.on_executor([this] {
    calibration::OfferResult offer;
    offer.name = "cross terms";
    offer.output = "q1";
    offer.taken = {effects::Term{{effects::Power{"x", 2}}}};
    offer.a90_validation_before = 12e-6;
    offer.a90_validation_after = 10e-6;
    models.offers = {offer};
  });
  const auto said = run({"fit", "--run", "1", "--model", "q1 ~ x", "--offers"});
  EXPECT_THAT(said.out, HasSubstr("stepwise takes x^2: -2.00 nm on the validation rows\n"));
}

// The fake answers with the model "first", as the daemon does where that has the same content.
TEST_F(CheckCommand, SaysThatAModelWasStoredBeforeUnderAnotherName) {
  const std::vector<std::string> fit = {"fit", "--run", "1", "--model", "q1 ~ x", "--name"};
  auto first = fit, second = fit;
  first.emplace_back("first");
  EXPECT_THAT(run(first).out, HasSubstr("stored as model 2\n"));
  second.insert(second.end(), {"second", "--note", "warm"});
  EXPECT_THAT(run(second).out,
              testing::AllOf(HasSubstr("was stored before as model 3, named 'first': not taken the "
                                       "name 'second' and the note\n"),
                             testing::Not(HasSubstr("stored as model"))));
}

TEST_F(CheckCommand, ShowsWhatOffersWouldAddOfARunToo) {
  cell.on_executor([this] {
    calibration::OfferResult offer;
    offer.name = "cross terms";
    offer.output = "q1";
    offer.best_p = 0.4;
    models.offers = {offer};
  });
  const auto said = run({"fit", "--run", "1", "--model", "q1 ~ x", "--offers"});
  EXPECT_THAT(said.out, HasSubstr("q1, cross terms: all rejected (smallest p 0.4)"));
  EXPECT_EQ(json({"fit", "--run", "1", "--model", "q1 ~ x", "--offers"})["offers"][0]["best_p"],
            0.4);
}

}  // namespace
}  // namespace driftwise::tests
