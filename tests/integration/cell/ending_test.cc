// The daemon is asked to end: in order, at once, and a restart goes on where it was.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

TEST(Ending, InTheMiddleOfARunIsOrderlyAndTheRestartGoesOn) {
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(8, 6));
  cell.wait_for_points(8);
  EXPECT_EQ(cell.stop_daemon(), 0) << cell.daemon_log();
  EXPECT_THAT(cell.daemon_log(), HasSubstr("shutting down"));
  EXPECT_EQ(cell.sql("SELECT state FROM run_progress"), "waiting");
  EXPECT_EQ(cell.cli({"status"}).code, 4);
  const auto points_before = cell.count("SELECT count(*) FROM planned_point");
  EXPECT_LT(points_before, 48);

  cell.start_daemon();
  const auto ended = cell.end_of(run);
  EXPECT_EQ(ended.at("state"), "done") << ended;
  EXPECT_EQ(ended.at("accepted_count"), 48);
  EXPECT_EQ(ended.at("restart_count"), 1);
  EXPECT_EQ(cell.sql("SELECT reason FROM datum ORDER BY datum_id DESC LIMIT 1"), "restart");
  EXPECT_NE(cell.sql("SELECT value FROM datum_value JOIN channel USING (channel_id) "
                     "WHERE name = 'zero_difference_nm'"),
            "")
      << "the new zero is compared with the one before";
  EXPECT_EQ(cell.stop_daemon(), 0);
}

TEST(Ending, WhenIdleIsQuickAndTakesTheNoticeAway) {
  CellAtWork cell;
  cell.start_daemon();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(cell.stop_daemon(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_THROW(read_file(cell.folder() + "/driftwised.json"), std::runtime_error);
  cell.start_daemon();
  EXPECT_EQ(cell.cli({"status"}).code, 0);
}

// docs/install.md: people who watch a cell need not be its service's user.
TEST(Ending, TheNoticeIsReadableWhateverTheServicesUmask) {
  CellAtWork cell;
  const auto before = ::umask(0077);
  cell.start_daemon();
  ::umask(before);
  struct stat found {};
  ASSERT_EQ(::stat((cell.folder() + "/driftwised.json").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0644u);
}

TEST(Ending, AClientWhoseTerminalGoesAwayGivesItsLeaseBack) {
  CellAtWork cell;
  cell.start_daemon();
  const auto plan = cell.write("plan.csv", campaign(8, 6));
  Process watch({std::string(DRIFTWISE_BIN_DIR) + "/driftwise", "--server", cell.grpc_address(),
                 "run", "start", plan, "--watch"});
  const auto held = [&] { return !cell.ask({"status"}).at("lease").is_null(); };
  wait_until("the lease to be taken", held);
  cell.wait_for_points(2);
  watch.signal(SIGHUP);
  EXPECT_EQ(watch.wait(std::chrono::seconds(30)), 130);
  EXPECT_FALSE(held());
  EXPECT_EQ(cell.state_of(1), "running");
}

TEST(Ending, NohupGoesOn) {
  CellAtWork cell;
  cell.start_daemon();
  const auto plan = cell.write("plan.csv", campaign(8, 6));
  Process watch({"/bin/sh", "-c", "trap '' HUP; exec \"$0\" \"$@\"",
                 std::string(DRIFTWISE_BIN_DIR) + "/driftwise", "--server", cell.grpc_address(),
                 "run", "start", plan, "--watch"});
  cell.wait_for_points(2);
  watch.signal(SIGHUP);
  EXPECT_EQ(watch.wait(std::chrono::minutes(2)), 0) << "the terminal went away, the watch did not";
  EXPECT_EQ(cell.state_of(1), "done");
}

}  // namespace
}  // namespace driftwise::tests
