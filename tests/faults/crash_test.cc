// Kills the daemon and judges it by what an outside watcher had been told: no acknowledged point
// lost, none doubled, every run completes. Real processes, real protocols, the simulated linear
// axis.

#include <gtest/gtest.h>
#include <signal.h>

#include <random>
#include <thread>

#include "tests/faults/acknowledged_points.h"
#include "tests/support/running_cell.h"

namespace driftwise::tests {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// lines of `per_line` rows, each beginning with its return to zero.
std::string trajectory_of(int lines, int per_line) {
  std::string csv = "q1_mm,set,line,zero\n";
  for (int line = 0; line < lines; ++line)
    for (int i = 0; i < per_line; ++i) {
      const double q_mm = i == 0 ? 0.0 : -2.0 + 4.0 * i / per_line + 0.125 * (line % 2);
      csv += std::to_string(q_mm) + (i % 2 ? ",validation," : ",calibration,") +
             std::to_string(line) + (i == 0 ? ",1\n" : ",0\n");
    }
  return csv;
}

void expect_nothing_lost(RunningCell& cell, const v1::Run& run,
                         const std::map<std::int64_t, SeenPoint>& acknowledged) {
  EXPECT_EQ(run.state(), v1::Run::STATE_DONE) << run.reason();
  EXPECT_EQ(run.accepted_count() + run.given_up_count(), run.row_count());
  const auto points = points_by_row(cell.channel(), run.id());
  EXPECT_EQ(static_cast<std::int64_t>(points.size()), run.accepted_count());
  for (const auto& [row, seen] : acknowledged) {
    const auto found = points.find(row);
    ASSERT_NE(found, points.end()) << "row " << row << " was acknowledged and is gone";
    EXPECT_EQ(found->second.values, seen.values)
        << "row " << row << " changed after it was acknowledged";
  }
  EXPECT_EQ(doubled_points_in(cell.database()), 0);
  EXPECT_EQ(integrity_of(cell.database()), "ok");
}

class CrashPoint : public testing::TestWithParam<const char*> {};

// The daemon dies at the second passing of the named point (the first, where there is only one), is
// started again, and finishes.
TEST_P(CrashPoint, LosesNoAcknowledgedPoint) {
  RunningCell cell({.speed = 200});
  cell.start_daemon({std::string("DRIFTWISE_CRASH_POINT=") + GetParam()});
  std::map<std::int64_t, SeenPoint> acknowledged;
  std::int64_t run_id = 0;
  try {  // some points are passed while the call is under way: then its answer never comes
    run_id = cell.create_run(trajectory_of(2, 4)).id();
    PointWatcher watcher(cell.channel(), run_id);
    watcher.join();
    acknowledged = watcher.seen();
  } catch (const std::runtime_error&) {
  }
  ASSERT_EQ(cell.daemon().wait(seconds(60)), 128 + SIGKILL)
      << GetParam() << " was never passed: " << cell.daemon_log();

  cell.start_daemon();
  if (run_id == 0) {  // whether the run got into the database before the kill is the crash point's
                      // business; a second try must work
    grpc::ClientContext context;
    v1::ListRunsResponse runs;
    ASSERT_TRUE(v1::RunService::NewStub(cell.channel())
                    ->ListRuns(&context, v1::ListRunsRequest(), &runs)
                    .ok());
    run_id = runs.runs_size() > 0 ? runs.runs(0).id() : cell.create_run(trajectory_of(2, 4)).id();
  }
  const v1::Run run = cell.wait_until_over(run_id, seconds(60));
  expect_nothing_lost(cell, run, acknowledged);
}

TEST(RandomKills, LoseNoAcknowledgedPointInOneRun) {
  constexpr int kKills = 20;
  constexpr unsigned kSeed = 20110722;
  RunningCell cell({.speed = 100, .seed = 3});
  cell.start_daemon();
  const std::int64_t run_id = cell.create_run(trajectory_of(12, 6)).id();
  std::mt19937 random(kSeed);
  std::map<std::int64_t, SeenPoint> acknowledged;
  int kills = 0;
  while (kills < kKills) {
    PointWatcher watcher(cell.channel(), run_id);
    // From right after the start to some points later; the start itself (homing, zero) is hit too.
    std::this_thread::sleep_for(milliseconds(std::uniform_int_distribution<int>(5, 1800)(random)));
    cell.kill_daemon();
    watcher.join();
    ++kills;
    for (const auto& [row, seen] : watcher.seen()) {
      const auto [known, fresh] = acknowledged.emplace(row, seen);
      if (!fresh) {
        EXPECT_EQ(known->second.values, seen.values) << "row " << row << " after kill " << kills;
      }
    }
    cell.start_daemon();
  }
  const v1::Run run = cell.wait_until_over(run_id, seconds(180));
  EXPECT_EQ(kills, kKills);
  RecordProperty("acknowledged_before_kills", static_cast<int>(acknowledged.size()));
  RecordProperty("restarts", static_cast<int>(run.restart_count()));
  expect_nothing_lost(cell, run, acknowledged);
}

}  // namespace
}  // namespace driftwise::tests
