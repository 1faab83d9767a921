// diagnose --run, diagnosis, improve: over the wire to a cell.

#include "clients/cli/commands/diagnoses/diagnosis_commands.h"

#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

namespace dx = driftwise::diagnosis;

class DiagnosisCommands : public CliTest {
 public:
  DiagnosisCommands() {
    fakes.extensions = &extensions;
    fakes.improvements = &improvements;
  }
  // In the record, done.
  DiagnosisId add(const dx::Diagnosis& found) {
    return cell.on_store([&](Store& store) {
      DiagnosisRecord record;
      record.baseline = found.baseline_formula;
      record.created = kWorldBegin;
      record.created_by = "ada";
      const auto id = store.diagnoses().add_diagnosis(record)->id;
      const DiagnosisEnd end{
          JobState::done, "", found.extended_formula, formats::write_stored_diagnosis(found), "",
          kWorldBegin};
      EXPECT_TRUE(store.diagnoses().end_diagnosis(id, end));
      return id;
    });
  }
  static dx::Diagnosis a_lag() {
    dx::Diagnosis found;
    found.verdict = dx::Verdict::extended;
    found.baseline_formula = "q ~ x";
    found.extended_formula = "q ~ x + lag(t07, 1830 s)";
    dx::OutputSummary q1;
    q1.output = "q1";
    q1.unit = "nm";
    q1.u90_calibration_before = 84.2;
    q1.u90_calibration_after = 12.4;
    q1.mean_calibration_after = 1.5;
    q1.a90_calibration_before = 91.7;
    q1.a90_calibration_after = 12.7;
    q1.explained_by = {{"t07", 0.41}};
    found.outputs = {q1};
    dx::Finding lag;
    lag.cause = "thermal_lag";
    lag.subject = "t07";
    lag.parameters = {{"tau_s", 1830, dx::Interval{1740, 1925}, {}}};
    lag.terms = {*formats::parse_term("lag(t07, 1830 s)")};
    lag.sentence = "the structure follows t07 with a delay of 1830 s";
    found.findings = {lag};
    return found;
  }
  FakeExtensions extensions{cell};
  FakeImprovements improvements;
};

TEST_F(DiagnosisCommands, ListWrongRowsWithoutAChannel) {
  auto found = a_lag();
  dx::Finding rows;
  rows.cause = "outliers";
  found.findings.insert(found.findings.begin(), rows);
  add(found);
  EXPECT_THAT(run({"diagnosis", "list"}).out, HasSubstr("outliers, thermal_lag t07"));
}

TEST_F(DiagnosisCommands, NameACauseThatCannotBeTestedOnce) {
  auto found = a_lag();
  found.not_testable = {{"cyclic_error", "x is visited at 3 places"},
                        {"cyclic_error", "y is visited at 3 places"},
                        {"abbe_offset", "no tilt"}};
  add(found);
  EXPECT_THAT(run({"diagnosis", "show", "1"}).out,
              HasSubstr("not testable with these data: cyclic_error; abbe_offset\n"));
}

TEST_F(DiagnosisCommands, ShowWhatWasFound) {
  add(a_lag());
  const auto said = run({"diagnosis", "show", "1"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("verdict   extended"));
  EXPECT_THAT(said.out, HasSubstr("1  thermal_lag t07"));
  EXPECT_THAT(said.out, HasSubstr("tau_s = 1830  (90 %: 1740 to 1925)"));
  EXPECT_THAT(said.out, HasSubstr("accuracy (A90), before -> after: 91.7 -> 12.7 nm (q1, the fit's "
                                  "own rows, none held out, mean +1.5 nm, S90 12.4 nm)"));
  const auto as_json = json({"diagnosis", "show", "1"});
  EXPECT_EQ(as_json["schema"], "driftwise.diagnosis.v1");
  EXPECT_EQ(as_json["verdict"], "extended");
  EXPECT_EQ(as_json["diagnosis"]["id"], 1);
  EXPECT_EQ(json({"diagnosis", "list"})["diagnoses"][0]["findings"][0]["cause"], "thermal_lag");
  EXPECT_EQ(run({"diagnosis", "show", "9"}).exit, 3);
}

TEST_F(DiagnosisCommands, AnUnexplainedOneSaysNoWithItsExitCode) {
  auto found = a_lag();
  found.verdict = dx::Verdict::unexplained;
  found.left_over = {{"line", 0.002}};
  add(found);
  const auto said = run({"diagnosis", "show", "1"});
  EXPECT_EQ(said.exit, 1);
  EXPECT_THAT(said.out, HasSubstr("left over: goes with line"));
}

TEST_F(DiagnosisCommands, AcceptAndUndo) {
  add(a_lag());
  extensions.makes = cell.add_model("q ~ x");
  const auto made = json({"diagnosis", "accept", "1", "--finding", "1", "--promote", "--yes"});
  EXPECT_EQ(made["model_id"], 1);
  EXPECT_EQ(made["promoted"], true);
  EXPECT_EQ(made["finding_numbers"], nlohmann::json({1}));
  EXPECT_TRUE(made["undo_time"].is_null());
  EXPECT_EQ(cell.on_executor([this] { return extensions.last_caller.name; }), "ada");
  EXPECT_FALSE(json({"diagnosis", "undo", "1"})["undo_time"].is_null());
  EXPECT_THAT(run({"diagnosis", "show", "1"}).out, HasSubstr("undone at"));
}

TEST_F(DiagnosisCommands, AcceptShowsTheSizesAndAsks) {
  add(a_lag());
  cell.on_executor([this] {
    extensions.the_preview.findings = {1};
    extensions.the_preview.sentences = {
        "changes x_mm of run 3 'weekend' by up to 3220 nm (rms 812 nm) in 200 rows",
        "earlier runs too: every export, fit and check of the runs above sees the corrected "
        "lengths"};
  });
  const auto accepted = [this] {
    return cell.on_store(
        [](Store& store) { return store.extensions().extension(DiagnosisId{1})->has_value(); });
  };
  const auto nobody = run({"diagnosis", "accept", "1"});  // no terminal
  EXPECT_EQ(nobody.exit, 2);
  EXPECT_THAT(nobody.err, HasSubstr("by up to 3220 nm"));
  EXPECT_THAT(nobody.err, HasSubstr("--yes"));
  EXPECT_FALSE(accepted());
  const auto declined = run({"diagnosis", "accept", "1"}, true, "\n");
  EXPECT_EQ(declined.exit, 5);
  EXPECT_THAT(declined.err, HasSubstr("accepting finding 1 of diagnosis 1:"));
  EXPECT_THAT(declined.err, HasSubstr("earlier runs too"));
  EXPECT_THAT(declined.err, HasSubstr("Accept it? [y/N]"));
  EXPECT_FALSE(accepted());
  const auto preview = run({"diagnosis", "preview", "1"});
  EXPECT_EQ(preview.exit, 0);
  EXPECT_THAT(preview.out, HasSubstr("by up to 3220 nm"));
  EXPECT_FALSE(accepted());
  EXPECT_EQ(run({"diagnosis", "accept", "1"}, true, "y\n").exit, 0);
  EXPECT_TRUE(accepted());
}

class DiagnosedAtTheDaemon : public CliTest {
 protected:
  DiagnosedAtTheDaemon()
      : CliTest(
            [this](const Dataset&, const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
              left_out = options.exclude_symbols;
              return DiagnosisCommands::a_lag();
            }) {}
  std::vector<std::string> left_out;  // of the search, on the cell's thread
};

TEST_F(DiagnosedAtTheDaemon, DiagnoseARunWaitsForItsEnd) {
  const auto csv = file("d.csv", "time_s,q1_mm,x_mm,t03_degC\n0,1,1,20\n1,2,2,20\n2,3,3.1,20\n");
  ASSERT_EQ(run({"data", "import", csv}).exit, 0);
  const auto said = run({"diagnose", "--run", "1", "--baseline", "q ~ x", "--without", "t03"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("diagnosis 1: done"));
  EXPECT_EQ(cell.on_executor([this] { return left_out; }), std::vector<std::string>{"t03"});
  EXPECT_EQ(json({"diagnosis", "show", "1"})["diagnosis"]["run_ids"], nlohmann::json({1}));
}

// Each is read from a file alone: of runs the daemon would go on without it.
TEST_F(DiagnosisCommands, OfRunsRefuseWhatOnlyAFileTakes) {
  for (const auto& [option, value] :
       std::vector<std::pair<std::string, std::string>>{{"--report", "out.html"},
                                                        {"--separating", "plan.csv"},
                                                        {"--robot-out", "robot.toml"},
                                                        {"--nulls", "50"},
                                                        {"--most", "2"},
                                                        {"--budget", "3"},
                                                        {"--threads", "2"}}) {
    const auto said = run({"diagnose", "--run", "3", "--baseline", "q ~ x", option, value});
    EXPECT_EQ(said.exit, 2) << option;
    EXPECT_THAT(said.err, HasSubstr(option + " goes with a file")) << option;
    EXPECT_THAT(said.err, HasSubstr("driftwise data export")) << option;
  }
}

TEST_F(DiagnosisCommands, RefuseWhatMeansNothing) {
  EXPECT_EQ(run({"diagnose"}).exit, 2);
  EXPECT_EQ(run({"diagnose", "data.csv", "--run", "3"}).exit, 2);
  EXPECT_EQ(run({"diagnose", "data.csv"}).exit, 2);  // no baseline
  const auto unknown = run({"diagnose", file("d.csv", "q1_mm,x_mm\n1,1\n2,2\n"), "--baseline",
                            "q ~ x", "--without", "t03"});
  EXPECT_EQ(unknown.exit, 3);
  EXPECT_THAT(unknown.err, HasSubstr("--without: unknown channel 't03'"));
  EXPECT_THAT(unknown.err, HasSubstr("d.csv has: q1 x"));
  EXPECT_EQ(run({"diagnose", "--run", "3", "--alpha", "0.9"}).exit, 2);
  EXPECT_EQ(run({"improve"}).exit, 2);
}

TEST_F(DiagnosisCommands, ImprovementsTurnByTurn) {
  const RunId run_id = cell.add_run(), again = cell.add_run();
  const ModelId model = cell.add_model("q ~ x");
  cell.on_store([&](Store& store) {
    ImprovementRecord record;
    record.created = kWorldBegin;
    record.trajectory_name = "plan.csv";
    record.formula = "q ~ x";
    ImprovementTurn turn;
    turn.runs = {run_id, again};
    turn.model = model;
    turn.what = "found a lag";
    turn.gains = {{"q1",
                   "nm",
                   {.u90 = 80, .a90 = 84.2},
                   ErrorFigures{.u90 = 12.4, .a90 = 12.4},
                   ErrorFigures{.u90 = 81, .a90 = 85.5},
                   ErrorFigures{.mean = 2.5, .u90 = 12.6, .a90 = 13.1}}};
    auto& jobs = store.improvements();
    const auto id = jobs.add_improvement(record)->id;
    ASSERT_TRUE(jobs.put_turn(id, turn));
    ImprovementTurn last;
    last.number = 2;
    ASSERT_TRUE(jobs.put_turn(id, last));
    ASSERT_TRUE(
        jobs.end_improvement(id, JobState::done, "nothing beyond noise is left", kWorldBegin));
  });
  const auto said = run({"improve", "show", "1"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("improvement 1: done: nothing beyond noise is left"));
  EXPECT_THAT(said.out, HasSubstr("84.2"));
  EXPECT_THAT(said.out, HasSubstr("13.1"));
  EXPECT_THAT(said.out, testing::ContainsRegex("\n +2 .* -  .* -\n")) << "a turn without figures";
  const auto as_json = json({"improve", "list"});
  EXPECT_EQ(as_json["improvements"][0]["turns"][0]["gains"][0]["measured"]["a90"], 13.1);
}

// Its loop measures again with the lease of who began it.
TEST_F(DiagnosisCommands, AnImprovementWhoseWatchingRunsOutOfTimeGoesOnAndKeepsTheLease) {
  cell.on_store([&](Store& store) {
    ImprovementRecord record;
    record.created = kWorldBegin;
    record.formula = "q ~ x";
    improvements.begins = *store.improvements().add_improvement(record);
  });
  const auto plan = file("plan.csv", "q1_mm\n0\n1\n0\n");
  const auto left = run({"improve", plan, "--model", "q ~ x", "--timeout", "0.5"});
  EXPECT_EQ(left.exit, 4);
  EXPECT_THAT(left.err, HasSubstr("improvement 1 goes on"));
  EXPECT_THAT(left.err, HasSubstr("driftwise improve cancel 1"));
  EXPECT_THAT(run({"lease", "show"}).out, HasSubstr("held by ada"));
}

}  // namespace
}  // namespace driftwise::tests
