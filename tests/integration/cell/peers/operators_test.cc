// Two people at one cell: one holds the lease to move, every one may pause, abort and stop.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

class Operators : public testing::Test {
 protected:
  // Ada starts a long run and watches it, which keeps her lease.
  void SetUp() override {
    cell.start_daemon();
    const auto file = cell.write("long.csv", campaign(100, 6));
    ada.emplace(cell.cli_process({"--operator", "ada", "run", "start", file, "--watch"}));
    cell.wait_for_points(2);
  }
  Finished bob(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--operator", "bob"});
    return cell.cli(arguments);
  }
  void expect_still() {
    const auto moves = cell.count("SELECT count(*) FROM move");
    const auto points = cell.count("SELECT count(*) FROM planned_point");
    const auto scans = [&] {
      return cell.count(
          "SELECT count(*) FROM reading JOIN device USING (device_id) "
          "WHERE device.name = 'scanner'");
    };
    const auto before = scans();  // the recorder goes on meanwhile
    wait_until("three more scans", [&] { return scans() >= before + 3; });
    EXPECT_EQ(cell.count("SELECT count(*) FROM move"), moves);
    EXPECT_EQ(cell.count("SELECT count(*) FROM planned_point"), points);
  }
  void wait_for_state(const std::string& state) {
    wait_until("state " + state, [&] { return cell.state_of(1) == state; });
  }

  CellAtWork cell;
  std::optional<Process> ada;
};

TEST_F(Operators, TheSecondIsRefusedTheLeaseByName) {
  auto refused = cell.refusal({"--operator", "bob", "lease", "take"});
  EXPECT_EQ(refused.at("exit"), 5);
  EXPECT_EQ(refused.at("code"), "permission_denied");
  EXPECT_THAT(refused.at("message").get<std::string>(), HasSubstr("ada"));
  EXPECT_EQ(bob({"move", "q1=1"}).code, 5);
  EXPECT_EQ(bob({"home"}).code, 5);
  EXPECT_EQ(cell.state_of(1), "running");
}

TEST_F(Operators, TheSecondMayPauseResumeAndAbort) {
  EXPECT_EQ(bob({"run", "pause", "1"}).code, 0);
  wait_for_state("paused");
  EXPECT_EQ(cell.run(1).at("reason"), "paused by bob");
  expect_still();
  EXPECT_EQ(bob({"run", "resume", "1", "--yes"}).code, 0);
  wait_for_state("running");
  cell.wait_for_points(cell.count("SELECT count(*) FROM planned_point") + 2);
  EXPECT_EQ(bob({"run", "abort", "1", "--reason", "lunch"}).code, 0);
  EXPECT_EQ(ada->wait(std::chrono::seconds(30)), 5) << "the watch says that the run was aborted";
  const auto ended = cell.run(1);
  EXPECT_EQ(ended.at("state"), "aborted");
  EXPECT_EQ(ended.at("reason"), "aborted by bob: lunch");
  expect_still();
  // What was accepted stays, and a run that is over takes no orders.
  EXPECT_GT(ended.at("accepted_count").get<int>(), 0);
  EXPECT_EQ(bob({"run", "resume", "1", "--yes"}).code, 5);
}

TEST_F(Operators, AnybodyStopsEverything) {
  const auto stopped = bob({"stop"});
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  wait_for_state("paused");
  EXPECT_THAT(cell.run(1).at("reason").get<std::string>(), HasSubstr("stopped by bob"));
  expect_still();
  // It goes on with the row it was at, as after a pause.
  const auto points = cell.count("SELECT count(*) FROM planned_point");
  EXPECT_EQ(cell.refusal({"--operator", "ada", "run", "resume", "1", "--yes"}).at("reason"),
            "STOPPED_BY_ANOTHER");
  EXPECT_EQ(cell.count("SELECT count(*) FROM event WHERE what = 'stop' AND run_id = 1"), 1)
      << "in the run's log";
  EXPECT_EQ(cell.cli({"--operator", "ada", "run", "resume", "1", "--yes", "--override",
                      "bob has left, the door is closed"})
                .code,
            0);
  EXPECT_THAT(cell.sql("SELECT detail FROM event WHERE what = 'run.resume'"),
              HasSubstr("the stop was overridden: bob has left, the door is closed"));
  cell.wait_for_points(points + 2);
  EXPECT_EQ(bob({"run", "abort", "1"}).code, 0);
  EXPECT_EQ(ada->wait(std::chrono::seconds(30)), 5);
  // Ada's lease ends with her watch: now it is Bob's turn.
  wait_until("the lease", [&] { return bob({"move", "q1=0.5"}).code == 0; });
}

}  // namespace
}  // namespace driftwise::tests
