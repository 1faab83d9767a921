// The queue of campaigns with real processes: kill -9 in the second of three entries, a person's
// stop, and an entry that is set aside.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/faults/crash_judge.h"

namespace driftwise::tests {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class QueueOfCampaigns : public testing::Test {
 protected:
  QueueOfCampaigns() { cell.start_daemon(); }

  void add(const std::string& name, const std::string& trajectory,
           std::vector<std::string> further = {}) {
    const auto path = cell.folder() + "/" + name + ".csv";
    std::ofstream(path) << trajectory;
    std::vector<std::string> words = {"queue", "add", path, "--name", name};
    words.insert(words.end(), further.begin(), further.end());
    const auto added = cell.cli(words);
    EXPECT_EQ(added.code, 0) << added.err;
  }
  // "done", "waiting", ...: of the entries, in their order.
  std::string states() {
    std::string text;
    for (std::int64_t id = 1; id <= entries(); ++id)
      text += (text.empty() ? "" : " ") +
              query_one(cell.database(),
                        "SELECT state FROM queue_entry WHERE entry_id = " + std::to_string(id));
    return text;
  }
  std::int64_t entries() { return count_of(cell.database(), "SELECT count(*) FROM queue_entry"); }
  // False: it did not come within two minutes of wall time.
  template <class Condition>
  bool comes(Condition condition) {
    const auto until = std::chrono::steady_clock::now() + seconds(120);
    while (!condition() && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(milliseconds(20));
    return condition();
  }
  bool second_is_measuring() {
    return comes([&] {
      return count_of(cell.database(), "SELECT count(*) FROM planned_point WHERE run_id = 2") >= 3;
    });
  }

  RunningCell cell{{.speed = 300}};
};

TEST_F(QueueOfCampaigns, MeasuresEveryPointOnceWhenKilledInTheSecond) {
  for (const char* name : {"a", "b", "c"})
    add(name, crash_trajectory(3, 6), {"--meta", "sample=A12"});
  ASSERT_TRUE(second_is_measuring()) << states() << cell.daemon_log();
  cell.kill_daemon();
  cell.start_daemon();
  ASSERT_TRUE(comes([&] { return states() == "done done done"; })) << states() << cell.daemon_log();
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM run"), 3);
  const auto rows = count_of(cell.database(), "SELECT sum(trajectory_rows) FROM run");
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM planned_point"), rows);
  EXPECT_EQ(
      count_of(cell.database(),
               "SELECT count(*) FROM (SELECT DISTINCT run_id, trajectory_row FROM planned_point)"),
      rows);
  const auto found = cell.cli({"run", "list", "--meta", "sample=A12", "--json"});
  EXPECT_EQ(nlohmann::json::parse(found.out)["runs"].size(), 3u);
  EXPECT_EQ(cell.cli({"audit", "verify"}).code, 0);
}

TEST_F(QueueOfCampaigns, IsHeldByAPersonsStopAlsoAfterAKill) {
  add("a", crash_trajectory(1, 2));
  add("b", crash_trajectory(3, 6));
  add("c", crash_trajectory(1, 2));
  ASSERT_TRUE(second_is_measuring()) << states();
  ASSERT_EQ(cell.cli({"stop"}).code, 0);
  cell.kill_daemon();
  cell.start_daemon();
  const auto held = cell.cli({"queue", "list"});
  EXPECT_NE(held.out.find("the queue is held: stopped by"), std::string::npos) << held.out;
  ASSERT_EQ(cell.cli({"run", "resume", "2", "--yes"}).code, 0);
  ASSERT_TRUE(comes([&] { return states() == "done done waiting"; })) << states();
  std::this_thread::sleep_for(seconds(1));  // five minutes of the cell
  EXPECT_EQ(states(), "done done waiting");
  ASSERT_EQ(cell.cli({"queue", "release"}).code, 0);
  EXPECT_TRUE(comes([&] { return states() == "done done done"; })) << states();
}

TEST_F(QueueOfCampaigns, WaitsForTheRoomThenFitsAndNotifies) {
  add("cold", crash_trajectory(1, 2), {"--when", "t01 < 5 degC for 10 min"});
  add("warm", crash_trajectory(4, 6),
      {"--when", "t01 > 5 degC for 5 min", "--then", "fit:q ~ x", "--then", "notify"});
  ASSERT_TRUE(comes([&] { return states() == "waiting done"; })) << states();
  const auto cold = cell.cli({"queue", "show", "1"});
  EXPECT_NE(cold.out.find("waits for t01_degC below 5 degC for 10 min: "), std::string::npos)
      << cold.out;
  const auto warm = cell.cli({"queue", "history"});
  EXPECT_NE(warm.out.find("model 1 was fitted"), std::string::npos) << warm.out;
  EXPECT_EQ(count_of(cell.database(), "SELECT count(*) FROM model"), 1);
  const auto alarms = cell.cli({"alarms"});
  EXPECT_NE(alarms.out.find("queue entry 2 'warm' is done: 24 of 24 rows accepted in run 1"),
            std::string::npos)
      << alarms.out;
  ASSERT_EQ(cell.cli({"queue", "edit", "1", "--when", ""}).code, 0);
  EXPECT_TRUE(comes([&] { return states() == "done done"; })) << states();
}

TEST_F(QueueOfCampaigns, SetsAFailedEntryAsideAndStartsTheNext) {
  add("broken", "x_mm\n0\n1\n0\n", {"--compensate", "--on-failure", "set-aside"});
  add("b", crash_trajectory(1, 2));
  ASSERT_TRUE(comes([&] { return states() == "set aside done"; })) << states();
  const auto listed = cell.cli({"queue", "list", "--json"});
  const auto entry = nlohmann::json::parse(listed.out)["entries"][0];
  EXPECT_NE(entry["reason"].get<std::string>().find("no model serves"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::tests
