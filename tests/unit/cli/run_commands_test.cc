#include <future>
#include <streambuf>
#include <utility>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

// Tells when the first line was written; what is written is of no interest.
class FirstLine final : public std::streambuf {
 public:
  std::promise<void> written;

 protected:
  int overflow(int c) override {
    if (c == '\n' && !std::exchange(is_told_, true)) written.set_value();
    return c;
  }

 private:
  bool is_told_ = false;
};

class RunCommandsTest : public CliTest {
 protected:
  RunCommandsTest() { fakes.runs = &runs; }
  FakeRuns runs;
  std::string trajectory() { return file("weekend.csv", "q1_mm\n0\n1\n0\n"); }
};

TEST_F(RunCommandsTest, StartsARunNamedAfterItsFileAndGivesTheLeaseBack) {
  const auto run_json = json({"run", "start", trajectory()});
  EXPECT_EQ(run_json["id"], 1);
  EXPECT_EQ(run_json["name"], "weekend.csv");
  EXPECT_EQ(run_json["state"], "running");
  EXPECT_EQ(run_json["operator_name"], "ada");
  EXPECT_EQ(run_json["end_time"], nullptr);
  EXPECT_EQ(run({"lease", "show"}).out, "free\n");
  EXPECT_FALSE(cell.on_executor([&] { return runs.last_create.request_id.empty(); }))
      << "a retry is safe";
}

TEST_F(RunCommandsTest, ADryRunStartsNothing) {
  const auto outcome = run({"run", "start", trajectory(), "--dry-run"});
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_THAT(outcome.out, HasSubstr("3 points ("));
  EXPECT_TRUE(cell.on_executor([&] { return runs.runs.empty(); }));
  EXPECT_TRUE(cell.on_executor([&] { return runs.last_create.validate_only; }))
      << "the daemon says what the start would be refused for";
}

TEST_F(RunCommandsTest, ADryRunNamesTheDevicesThatDoNotAnswer) {
  EXPECT_THAT(run({"run", "start", trajectory(), "--dry-run"}).err,
              testing::Not(HasSubstr("does not answer")));
  cell.on_executor([&] { cell.world.laser_away = true; });
  const auto outcome = run({"run", "start", trajectory(), "--dry-run"});
  EXPECT_EQ(outcome.exit, 0) << "the plan is good";
  EXPECT_THAT(outcome.err, HasSubstr("warning: device 'laser-x' at 127.0.0.1:1 does not answer"));
}

TEST_F(RunCommandsTest, PassesOnWhatTheRunIsToBe) {
  json({"run", "start", trajectory(), "--name", "n", "--compensate", "--model", "4", "--readings",
        "6"});
  const auto asked = cell.on_executor([&] { return runs.last_create; });
  EXPECT_EQ(asked.name, "n");
  EXPECT_TRUE(asked.compensate);
  EXPECT_EQ(asked.compensate_with, ModelId{4});
  EXPECT_EQ(asked.rules->readings_per_point, 6);
}

TEST_F(RunCommandsTest, AKeyToRemoveTakesNoOtherWordWithIt) {
  json({"run", "start", trajectory()});
  json({"run", "tag", "1", "tool=probe"});
  EXPECT_EQ(json({"run", "tag", "1", "--remove", "tool", "sample=A12"})["metadata"],
            nlohmann::json::parse(R"([{"key": "sample", "value": "A12"}])"));
  const auto refused = run({"run", "tag", "1", "--remove", "sample=A12"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("found 'sample=A12', expected a key alone"));
}

TEST_F(RunCommandsTest, ConfirmsTheForceThatARunWaitsFor) {
  json({"run", "start", trajectory()});
  EXPECT_EQ(json({"run", "confirm", "1", "--force", "2.305"})["state"], "running");
  EXPECT_EQ(cell.on_executor([&] { return runs.last_force_n; }), 2.305);
  EXPECT_EQ(run({"run", "confirm", "1"}).exit, 2) << "what hangs there must be said";
}

TEST_F(RunCommandsTest, MakesAPlanWithoutADaemon) {
  const auto made =
      run({"trajectory", "grid", "--axes", "q1,q2", "--block", "calibration 0:1:0.5 force=2.305",
           "--block", "validation 0:1 scattered=3"});
  EXPECT_EQ(made.exit, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("# made by: driftwise trajectory grid --axes q1,q2 --block "
                                  "'calibration 0:1:0.5 force=2.305'"));
  EXPECT_THAT(made.out,
              HasSubstr("q1_mm,q2_mm,set,line,zero,force_N\n0,0,calibration,1,0,2.305\n"));
  const auto wrong = run({"trajectory", "grid", "--axes", "q1", "--block", "calibration 0:1"});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr("FROM:TO:STEP"));
}

TEST_F(RunCommandsTest, TakesAPlanToThePosesOfTheDrawing) {
  const std::string drawing =
      std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/micro-nano/cell.toml";
  const auto made = run({"trajectory", "grid", "--axes", "q1,q2,q3", "--block", "calibration 1:1:1",
                         "--to-pose", drawing});
  EXPECT_EQ(made.exit, 0) << made.err;
  // Three equal carriages lift the platform straight up.
  EXPECT_THAT(made.out, HasSubstr("x_mm,y_mm,z_mm,set,line,zero\n"));
  EXPECT_THAT(made.out, HasSubstr(",1,calibration,1,0\n"));
  EXPECT_THAT(made.out, HasSubstr("0,0,0,calibration,1,1\n")) << "a return to zero stays one";
}

TEST_F(RunCommandsTest, WaitsForTheLeaseHolderByName) {
  ASSERT_EQ(run({"lease", "take", "--hold", "120", "--operator", "bob"}).exit, 0);
  const auto outcome = run({"run", "start", trajectory()});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, testing::AllOf(testing::StartsWith("driftwise: bob ("),
                                          HasSubstr("holds the lease")));
}

TEST_F(RunCommandsTest, WatchesToTheEndAndExitsWithItsVerdict) {
  json({"run", "start", trajectory()});
  for (const auto& [state, exit] :
       {std::pair{RunState::done, 0}, {RunState::failed, 5}, {RunState::aborted, 5}}) {
    cell.on_executor([&, state = state] { runs.runs[1].state = state; });
    EXPECT_EQ(run({"run", "watch", "1"}).exit, exit) << to_string(state);
  }
}

TEST_F(RunCommandsTest, AWatchThatRunsOutOfTimeLeavesTheRunAlone) {
  json({"run", "start", trajectory()});
  cell.add_run();  // in the record, for what is read from there
  cell.on_executor([&] { runs.tells_at_once = true; });
  const auto outcome = run({"run", "watch", "1", "--timeout", "0.3"});
  EXPECT_EQ(outcome.exit, 4);
  EXPECT_THAT(outcome.err, HasSubstr("run 1 goes on"));
  EXPECT_THAT(outcome.err, HasSubstr("driftwise run abort 1"));
}

// Its streams are cancelled without a reason; the run itself waits for the next start.
TEST_F(RunCommandsTest, AWatchSaysThatTheRunGoesOnWhenTheDaemonEnds) {
  json({"run", "start", trajectory()});
  cell.add_run();
  cell.on_executor([&] { runs.tells_at_once = true; });
  FirstLine line;
  std::ostream out(&line);
  std::ostringstream err;
  cli::Console console{out, err, false, false, 80, environment, folder.path()};
  auto watching = std::async(std::launch::async, [&] {
    return cli::run_cli({"run", "watch", "1", "--json", "--timeout", "60"}, console);
  });
  line.written.get_future().wait();
  server->shut_down(std::chrono::milliseconds(0));
  EXPECT_EQ(watching.get(), 4);
  EXPECT_THAT(err.str(), testing::AllOf(HasSubstr("NO_DAEMON"), HasSubstr("ended meanwhile"),
                                        HasSubstr("run 1 goes on when it starts")));
}

TEST_F(RunCommandsTest, ListsRunsAsATable) {
  const RunId id = cell.add_run("weekend");
  cell.add_points(id, 3);
  cell.on_store([id](Store& store) {
    RunChange change;
    change.state = RunState::done;
    change.started = {1'700'000'000'000'000'000};
    change.ended = *change.started + std::chrono::seconds(14520);
    ASSERT_TRUE(store.runs().change_run(id, change));
  });
  EXPECT_EQ(run({"run", "list"}).out,
            "run  name     state  points  given up  attempts  started (UTC)              took  "
            "compensated  operator  rests on\n"
            "  1  weekend  done    3/100         0         3  2023-11-14 22:13:20  4 h 02 min  "
            "no       "
            "    ada\n");
}

TEST_F(RunCommandsTest, PausesResumesAndAborts) {
  json({"run", "start", trajectory()});
  cell.add_run();  // in the record, for what is read from there
  EXPECT_EQ(json({"run", "pause", "1"})["reason"], "paused by ada");
  const auto unasked = run({"run", "resume", "1"});
  EXPECT_EQ(unasked.exit, 2) << "nobody is there to be asked";
  EXPECT_THAT(unasked.err, testing::HasSubstr("run 1 was paused by ada"));
  const auto no = run({"run", "resume", "1"}, true, "n\n");
  EXPECT_EQ(no.exit, 5) << no.err;
  EXPECT_EQ(json({"run", "show", "1"})["run"]["state"], "paused");
  EXPECT_EQ(run({"run", "resume", "1"}, true, "y\n").exit, 0);
  EXPECT_EQ(json({"run", "pause", "1"})["state"], "paused");
  EXPECT_EQ(json({"run", "resume", "1", "--yes", "--override", "ada left"})["state"], "running");
  EXPECT_EQ(runs.last_answer.hold_id, kWorldBegin.utc_ns);
  EXPECT_EQ(runs.last_answer.override_reason, "ada left");
  EXPECT_EQ(json({"run", "abort", "1", "--reason", "door open"})["reason"], "door open");
  EXPECT_EQ(run({"run", "pause", "1"}).exit, 5);
}

TEST_F(RunCommandsTest, AnAbortPrintsWhatBecameOfTheRun) {
  json({"run", "start", trajectory()});
  cell.add_run();  // in the record, for what is read from there
  cell.on_executor([&] { runs.aborts_later = true; });
  const auto outcome = run({"run", "abort", "1", "--reason", "door open"});
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_THAT(outcome.out, HasSubstr("aborted"));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("running")));
}

TEST_F(CliTest, TheStatusDuringARunSaysWhoMovesTheRobot) {
  EXPECT_THAT(run({"status"}).out, HasSubstr("lease    free\n"));
  ASSERT_EQ(run({"run", "start", file("plan.csv", "q1_mm\n0\n1\n0\n")}).exit, 0);
  EXPECT_THAT(run({"status"}).out,
              HasSubstr("lease    nobody holds it; run 1 moves the robot until it ends\n"));
}

TEST_F(RunCommandsTest, ShowsPointsWithNullForWhatWasNotMeasured) {
  const RunId id = cell.add_run();
  PointRecord point;
  point.values = {{"x_mm", 1.5}, {"t07_degC", kMissing}};
  cell.add_points(id, {point});
  cell.on_store([id](Store& store) {
    PointCommit commit;
    commit.run = id;
    AttemptRecord attempt;
    attempt.row = 1;
    attempt.verdict = Verdict::given_up;
    attempt.reason = "spread 7.3 nm of 4 readings, limit 5 nm";
    attempt.spread_nm = 7.3;
    attempt.started = attempt.ended = {kWorldBegin, 0};
    commit.attempts = {attempt};
    ASSERT_TRUE(store.points().commit(commit));
  });
  const auto points = json({"run", "points", "1"});
  EXPECT_EQ(points["points"][0]["values"]["x_mm"], 1.5);
  EXPECT_EQ(points["points"][0]["values"]["t07_degC"], nullptr);
  EXPECT_EQ(points["points"][0]["dwell_s"], 0.0);
  EXPECT_EQ(json({"run", "attempts", "1"})["attempts"][1]["verdict"], "given_up");
  EXPECT_THAT(run({"run", "attempts", "1"}).out, HasSubstr("given_up        7.3"));
}

// A point whose thermometer was not read must not move the other values under wrong headers.
TEST_F(RunCommandsTest, PutsEveryValueOfAPointUnderItsOwnHeader) {
  PointRecord first, second;
  first.values = {{"t01_degC", 20.25}, {"x_mm", 1.5}, {"q1_mm", 1.25}};
  second.values = {{"x_mm", 2.5}, {"t02_degC", 21.75}, {"q1_mm", 2.25}};
  cell.add_points(cell.add_run(), {first, second});
  std::istringstream table(run({"run", "points", "1"}).out);
  std::string header, one, two;
  std::getline(table, header);
  std::getline(table, one);
  std::getline(table, two);
  EXPECT_THAT(header, testing::EndsWith("q1_mm      x_mm  t01_degC  t02_degC"));
  EXPECT_THAT(one, testing::EndsWith("1.250000  1.500000   20.2500         -"));
  EXPECT_THAT(two, testing::EndsWith("2.250000  2.500000         -   21.7500"));
}

TEST_F(RunCommandsTest, SaysThatNoRunMatches) {
  EXPECT_THAT(run({"run", "list"}).out, HasSubstr("no runs yet"));
  cell.add_run();
  EXPECT_EQ(run({"run", "list", "--meta", "nothing=there"}).out,
            "no run matches --meta nothing=there: driftwise run list shows all\n");
}

TEST_F(RunCommandsTest, KeptTrajectoriesHaveTheirTimesInUtc) {
  EXPECT_THAT(run({"trajectory", "upload", trajectory()}).out,
              testing::ContainsRegex("kept by ada [0-9]+-[0-9-]+ [0-9:]+ UTC\n"));
  EXPECT_THAT(run({"trajectory", "list"}).out, HasSubstr("kept (UTC)"));
}

TEST_F(RunCommandsTest, EventsHaveTheirTimesInUtc) {
  ASSERT_EQ(run({"lease", "take", "--hold", "120"}).exit, 0);
  EXPECT_THAT(run({"events"}).out, testing::ContainsRegex(":[0-9][0-9] UTC  lease.taken"));
}

TEST_F(RunCommandsTest, ExportsToAFileInOnePiece) {
  ASSERT_EQ(run({"data", "import", file("in.csv", "time_s,q1_mm,x_mm\n0,0,0\n")}).exit, 0);
  const std::string text = run({"data", "export", "1"}).out;
  EXPECT_THAT(text, HasSubstr("q1_mm"));
  const std::string path = folder.path() + "/out.csv";
  EXPECT_EQ(run({"data", "export", "1", "-o", path}).exit, 0);
  EXPECT_EQ(read_file(path), text);
  EXPECT_EQ(run({"data", "export", "1", "-o", folder.path() + "/no/such/out.csv"}).exit, 3);
  EXPECT_EQ(json({"data", "import", path})["name"], "out.csv");
}

TEST_F(RunCommandsTest, MovesWithinTheLimitsAndChecksThemWithoutMoving) {
  {
    const auto passing = cell.passing();
    ASSERT_EQ(run({"home"}).exit, 0);
    EXPECT_EQ(run({"move", "q1=0.25"}).exit, 0);
  }
  EXPECT_EQ(run({"move", "q1=99", "--dry-run"}).exit, 5);
  EXPECT_EQ(run({"move", "q2=1", "--dry-run"}).exit, 3);
  EXPECT_EQ(run({"move", "q1=1", "--dry-run"}).exit, 0);
  EXPECT_EQ(run({"home", "--dry-run"}).exit, 0);
  EXPECT_EQ(cell.last_event("axes.move")->who, "ada");
  EXPECT_EQ(run({"lease", "show"}).out, "free\n");
}

TEST_F(RunCommandsTest, LeasesCanBeHeldAcrossCommands) {
  const auto lease = json({"lease", "take", "--hold", "120"});
  EXPECT_EQ(lease["holder"], "ada");
  const std::string token = lease["token"];
  EXPECT_THAT(run({"lease", "show"}).out, HasSubstr("held by ada"));
  EXPECT_EQ(run({"lease", "give-up", token}).exit, 0);
  EXPECT_EQ(run({"lease", "show"}).out, "free\n");
}

TEST_F(RunCommandsTest, ShowsTheStatus) {
  EXPECT_THAT(run({"status"}).out, HasSubstr("t01_degC            20.1"));
  const auto status = json({"status"});
  EXPECT_EQ(status["cell_name"], "small");
  EXPECT_EQ(status["run"], nullptr);
  EXPECT_EQ(status["devices"][0]["id"], "axis");
}

}  // namespace
}  // namespace driftwise::tests
