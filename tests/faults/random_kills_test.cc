// Twenty kills at seeded instants during one run, judged by what an outside watcher had been told.

#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "tests/faults/crash_judge.h"

namespace driftwise::tests {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(RandomKills, LoseNoAcknowledgedPointInOneRun) {
  constexpr int kKills = 20;
  constexpr unsigned kSeed = 20110722;
  // At this speed homing and zeroing take about 0.4 s, a point 0.08 s: a life ends in either.
  RunningCell cell({.speed = 100, .seed = 3});
  cell.start_daemon();
  const std::int64_t run_id = cell.create_run(crash_trajectory(12, 12)).id();
  std::mt19937 random(kSeed);
  PointsByRow acknowledged;
  std::int64_t told = 0, met_the_run = 0;
  for (int kill = 1; kill <= kKills; ++kill) {
    PointWatcher watcher(cell.channel(), run_id);
    // From right after the start to some points later: homing and zeroing are hit too.
    std::this_thread::sleep_for(milliseconds(std::uniform_int_distribution<int>(5, 1100)(random)));
    cell.kill_daemon();
    watcher.join();
    told = std::max(told, watcher.acknowledged_count());
    const auto left = left_behind(cell.database());
    EXPECT_GE(left.points, told) << "a point was acknowledged and is not on the disk, kill "
                                 << kill;
    met_the_run += left.has_begun();
    for (const auto& [row, seen] : watcher.seen()) {
      const auto [known, fresh] = acknowledged.emplace(row, seen);
      if (!fresh) {
        EXPECT_EQ(known->second.values, seen.values) << "row " << row << " after kill " << kill;
      }
    }
    cell.start_daemon();
  }
  EXPECT_EQ(met_the_run, kKills) << "the run was over before the last kill: make it longer";
  const v1::Run run = cell.wait_until_over(run_id, seconds(120));
  RecordProperty("acknowledged_before_kills", static_cast<int>(acknowledged.size()));
  RecordProperty("restarts", static_cast<int>(run.restart_count()));
  EXPECT_GT(acknowledged.size(), 10u);
  // A life can be too short to take the run up again; most are not.
  EXPECT_GT(run.restart_count(), kKills / 2);
  EXPECT_LE(run.restart_count(), kKills);
  expect_nothing_lost(cell, run, acknowledged);
}

}  // namespace
}  // namespace driftwise::tests
