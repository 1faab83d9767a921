// What goes wrong with devices in a run: it waits, goes on, and what happened is on record.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

constexpr int kRunRows = 30;

class DeviceFaults : public testing::Test {
 protected:
  // A run that meets the fault after some points, to its end. Meanwhile this count must become more
  // than 0.
  void run_with(const std::string& fault, const std::string& seen_in_the_database = {}) {
    cell.start_daemon();
    const auto run = cell.start_run(campaign(5, 6));
    cell.wait_for_points(6);
    cell.control(fault);
    if (!seen_in_the_database.empty())
      wait_until(seen_in_the_database, [&] { return cell.count(seen_in_the_database) > 0; });
    ended = cell.end_of(run);
    trouble = cell.sql("SELECT detail FROM event WHERE what = 'run.trouble' ORDER BY event_id");
  }
  void expect_whole() {
    EXPECT_EQ(ended.at("state"), "done") << ended << cell.daemon_log();
    EXPECT_EQ(ended.at("accepted_count"), kRunRows);
    EXPECT_EQ(cell.count("SELECT count(DISTINCT trajectory_row) FROM planned_point"), kRunRows);
  }

  CellAtWork cell;
  nlohmann::json ended;
  std::string trouble;  // the first that the run's record speaks of
};

nlohmann::json device(const CellAtWork& cell, const std::string& id) {
  const auto all = cell.ask({"devices"});
  for (const auto& one : all.is_array() ? all : all.at("devices"))
    if (one.at("id") == id) return one;
  throw std::runtime_error("no device " + id);
}

TEST_F(DeviceFaults, ARunWaitsForADroppedAxisAndResumes) {
  run_with("fault drop axis for 200 s",
           "SELECT count(*) FROM run_progress WHERE state = 'waiting' AND reason LIKE '%axis%'");
  expect_whole();
  EXPECT_THAT(trouble, HasSubstr("axis"));
  EXPECT_GE(cell.events("device.lost"), 1);
  EXPECT_GE(cell.events("device.back"), 1);
  EXPECT_GE(device(cell, "axis").at("reconnect_count").get<int>(), 1);
  EXPECT_GE(cell.count("SELECT count(*) FROM attempt WHERE verdict = 'interrupted'"), 1);
}

TEST_F(DeviceFaults, ARunGoesOnAfterADamagedReply) {
  run_with("fault garble laser-x");
  expect_whole();
  const auto laser = device(cell, "laser-x");
  EXPECT_GE(laser.at("error_count").get<int>(), 1) << laser;
  EXPECT_THAT(laser.at("last_error").get<std::string>(), HasSubstr("laser-x"));
}

TEST_F(DeviceFaults, ARunOutlastsASilentScanner) {
  run_with("fault mute scanner 30 s");
  expect_whole();
  EXPECT_GE(device(cell, "scanner").at("error_count").get<int>(), 1);
  // No point without its temperatures, however long that took.
  EXPECT_EQ(cell.count("SELECT count(*) FROM point_wide WHERE is_passage = 0 AND t05_degC IS NULL"),
            0);
}

TEST_F(DeviceFaults, ADisturbedGroupIsReadAgainAndStaysOnRecord) {
  run_with("fault disturb laser-x 40 s 120 nm");
  EXPECT_EQ(ended.at("state"), "done");
  EXPECT_GE(cell.count("SELECT count(*) FROM attempt WHERE verdict = 'reread'"), 1);
  EXPECT_THAT(cell.sql("SELECT reason FROM attempt WHERE verdict = 'reread' LIMIT 1"),
              testing::MatchesRegex(".*nm of 4 readings, limit 5 nm.*"));
  // What was thrown away is kept: the readings of the attempt that failed.
  EXPECT_GE(cell.count("SELECT count(*) FROM reading JOIN attempt USING (attempt_id) "
                       "WHERE verdict = 'reread'"),
            4);
  EXPECT_EQ(cell.count("SELECT count(*) FROM point_wide WHERE x_std_nm > 5"), 0);
}

}  // namespace
}  // namespace driftwise::tests
