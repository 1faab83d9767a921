// Kills the daemon at each named point of docs/crash-points.md and judges it by what an outside
// watcher had been told: no acknowledged point lost, none doubled, every run completes. Real
// processes, real protocols, the simulated linear axis.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <vector>

#include "tests/faults/crash_judge.h"

namespace driftwise::tests {
namespace {

using std::chrono::seconds;

struct Kill {
  const char* what;  // "point": before_point_commit and after_point_commit
  int passing;
};

// The passings are chosen so that there is something to lose. A run changes its state twice: when
// it begins and when it is done.
constexpr Kill kKillsInARun[] = {{"run_create", 1}, {"run_state", 1}, {"run_state", 2},
                                 {"datum", 1},      {"point", 1},     {"point", 6},
                                 {"readings", 2},   {"event", 5}};

// "before_point_commit:6": the sixth passing.
std::vector<std::string> kills_in_a_run() {
  std::vector<std::string> kills;
  for (const char* side : {"before", "after"})
    for (const auto& kill : kKillsInARun)
      kills.push_back(std::string(side) + "_" + kill.what +
                      "_commit:" + std::to_string(kill.passing));
  return kills;
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

class CrashPoint : public testing::TestWithParam<std::string> {};

TEST_P(CrashPoint, LosesAndDoublesNoPoint) {
  const auto trajectory = crash_trajectory(2, 4);
  RunningCell cell({.speed = 300});
  cell.start_daemon({"DRIFTWISE_CRASH_POINT=" + GetParam()});
  PointsByRow acknowledged;
  std::int64_t told = 0;
  try {  // some points are passed while the call is under way: then its answer never comes
    PointWatcher watcher(cell.channel(), cell.create_run(trajectory, "the-one").id());
    watcher.join();
    acknowledged = watcher.seen();
    told = watcher.acknowledged_count();
  } catch (const std::runtime_error&) {
  }
  ASSERT_EQ(cell.daemon().wait(seconds(60)), 128 + SIGKILL)
      << GetParam() << " was never passed: " << cell.daemon_log();
  const auto left = left_behind(cell.database());
  EXPECT_GE(left.points, told) << "a point was acknowledged and is not on the disk";

  cell.start_daemon();
  // Whoever had no answer asks again: his request names one run, whatever became of the first try.
  const auto id = cell.create_run(trajectory, "the-one").id();
  const auto run = cell.wait_until_over(id, seconds(60));
  expect_nothing_lost(cell, run, acknowledged);
  expect_restart_recorded(cell, run, left);
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM run"), 1);
}

INSTANTIATE_TEST_SUITE_P(Each, CrashPoint, testing::ValuesIn(kills_in_a_run()), test_name);

class ModelCrashPoint : public testing::TestWithParam<std::string> {};

// A model is there whole or not at all, and a promotion likewise; trying again works.
TEST_P(ModelCrashPoint, LeavesAWholeModelOrNone) {
  RunningCell cell({.speed = 300});
  cell.start_daemon({"DRIFTWISE_CRASH_POINT=" + GetParam()});
  const auto run = cell.create_run(crash_trajectory(2, 6), "the-one");
  ASSERT_EQ(cell.wait_until_over(run.id(), seconds(60)).state(), v1::Run::STATE_DONE);
  const std::vector<std::string> fit = {"fit", "--run", "1", "--model", "q ~ x + x^2"};
  const std::vector<std::string> promote = {"model", "promote", "1", "--yes"};
  const bool fitted = cell.cli(fit).code == 0;
  if (fitted) {
    EXPECT_EQ(cell.cli(promote).code, 4) << "the daemon died while it was asked";
  }
  ASSERT_EQ(cell.daemon().wait(seconds(10)), 128 + SIGKILL) << cell.daemon_log();

  cell.start_daemon();
  const auto models = count_of(cell.database(), "SELECT count(*) FROM model");
  EXPECT_EQ(models, GetParam() == "before_model_commit" ? 0 : 1);
  const auto promotions = count_of(cell.database(), "SELECT count(*) FROM promotion");
  EXPECT_EQ(promotions, GetParam() == "after_promotion_commit" ? 1 : 0);
  EXPECT_EQ(cell.cli({"target", "x=1"}).code, promotions > 0 ? 0 : 5);
  if (models == 0) {
    EXPECT_EQ(cell.cli(fit).code, 0);
  }
  EXPECT_EQ(cell.cli(promote).code, 0);
  EXPECT_EQ(cell.cli({"target", "x=1"}).code, 0);
  EXPECT_EQ(query_one(cell.database(), "PRAGMA integrity_check"), "ok");
}

const std::vector<std::string> kModelKills = {"before_model_commit", "after_model_commit",
                                              "before_promotion_commit", "after_promotion_commit"};
INSTANTIATE_TEST_SUITE_P(Each, ModelCrashPoint, testing::ValuesIn(kModelKills), test_name);

// Killed on virtual time, in tests/unit/application: diagnosis/extension_crash_test.cc,
// upkeep/configuration_test.cc, queue/queue_test.cc.
const std::vector<std::string> kKilledInMemory = {
    "before_extension_commit", "after_extension_commit",      "before_undo_commit",
    "after_undo_commit",       "before_configuration_commit", "after_configuration_commit",
    "before_queue_commit",     "after_queue_commit"};

class StopCrashPoint : public testing::TestWithParam<std::string> {};

// A stop that reached the disk is pending after the restart or confirmed before it, and the run is
// paused either way. One that did not was never answered, and the run goes on.
TEST_P(StopCrashPoint, TheRunIsPausedWhenTheStopWasStored) {
  RunningCell cell({.speed = 300});
  cell.start_daemon({"DRIFTWISE_CRASH_POINT=" + GetParam()});
  const auto run = cell.create_run(crash_trajectory(10, 12), "the-one");
  while (cell.daemon().running() &&
         count_of(cell.database(), "SELECT count(*) FROM planned_point") < 3)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  cell.cli({"stop"});
  ASSERT_EQ(cell.daemon().wait(seconds(60)), 128 + SIGKILL) << cell.daemon_log();
  const auto points = count_of(cell.database(), "SELECT count(*) FROM planned_point");

  cell.start_daemon();
  if (GetParam() == "before_stop_commit") {
    EXPECT_EQ(cell.wait_until_over(run.id(), seconds(60)).state(), v1::Run::STATE_DONE);
    return;
  }
  EXPECT_EQ(cell.wait_until_over(run.id(), seconds(3)).state(), v1::Run::STATE_PAUSED);
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM planned_point"), points);
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM stop WHERE confirmed_ns = 0"), 0)
      << "sent again after the restart, and confirmed";
}

const std::vector<std::string> kStopKills = {"before_stop_commit", "after_stop_commit",
                                             "before_stop_confirm_commit",
                                             "after_stop_confirm_commit"};
INSTANTIATE_TEST_SUITE_P(Each, StopCrashPoint, testing::ValuesIn(kStopKills), test_name);

std::set<std::string> names_in(const std::string& text) {
  static const std::regex name("(before|after)_[a-z_]+_commit");
  std::set<std::string> names;
  for (std::sregex_iterator i(text.begin(), text.end(), name), end; i != end; ++i)
    names.insert(i->str());
  return names;
}

TEST(CrashPoints, AreTheSameInTheManualTheCodeAndTheseTests) {
  const std::string source = DRIFTWISE_SOURCE_DIR;
  std::set<std::string> in_code, killed;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(source + "/server"))
    if (entry.path().extension() == ".cc") in_code.merge(names_in(read_file(entry.path())));
  for (const auto& kill : kKillsInARun)
    for (const char* side : {"before_", "after_"})
      killed.insert(std::string(side) + kill.what + "_commit");
  for (const auto* names : {&kModelKills, &kKilledInMemory, &kStopKills})
    for (const auto& name : *names) killed.insert(name);
  EXPECT_EQ(names_in(read_file(source + "/docs/crash-points.md")), in_code);
  EXPECT_EQ(killed, in_code);
}

}  // namespace
}  // namespace driftwise::tests
