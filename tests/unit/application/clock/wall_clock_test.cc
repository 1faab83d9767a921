// The wall clock is set while a run is under way: issue 11, number 12.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "server/application/support/support_bundles.h"
#include "server/formats/text/gzip.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

const std::string kClockRows = lines_of(2, {2, -3, 1, 4}, true);

struct StepOutcome {
  RunRecord run;
  std::vector<PointRecord> points;
  std::vector<std::string> steps;  // details of the events
  std::vector<AlarmRecord> alarms;
  std::vector<double> time_s;  // of the exported dataset
  Nanoseconds utc_offset{0};
};

std::vector<double> first_column(const std::string& csv) {
  std::vector<double> values;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && (std::isdigit(line[0]) || line[0] == '-'))
      values.push_back(std::stod(line));
  return values;
}

// A run of which the wall clock is set by the steps, one after every third point.
StepOutcome run_with(const std::vector<double>& steps_s) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite);
  const auto id = cell.begin_run(kClockRows).id;
  std::int64_t at_point = 3;
  for (const double step_s : steps_s) {
    cell.until([&] { return cell.status().run->run.accepted == at_point; }, 3600);
    cell.time().wall_clock_set += nanoseconds_from_s(step_s);
    at_point += 3;
  }
  StepOutcome outcome;
  outcome.run = cell.finish_run();
  cell.pass(5);
  outcome.points = *cell.await(cell.points(id, 0, 1000));
  outcome.steps = cell.events_named("clock.stepped");
  const auto alarms = *cell.await(cell->alarms.list(true, 100));
  for (const auto& alarm : alarms)
    if (alarm.kind == "clock.stepped") outcome.alarms.push_back(alarm);
  const auto csv = *cell.await(cell->datasets.export_csv({id}, false));
  EXPECT_THAT(csv, HasSubstr("\ntime_s,"));
  outcome.time_s = first_column(csv);
  outcome.utc_offset = Nanoseconds(cell->host.utc(cell.now()).ns - cell.now().utc_ns);
  return outcome;
}

struct StepCase {
  const char* name;
  std::vector<double> steps_s;
};
class WallClockSet : public testing::TestWithParam<StepCase> {};

TEST_P(WallClockSet, ChangesNoRowAndIsAnEventAndAnAlarm) {
  const auto undisturbed = run_with({});
  const auto outcome = run_with(GetParam().steps_s);
  EXPECT_EQ(outcome.run.state, RunState::done) << outcome.run.reason;
  EXPECT_EQ(outcome.run.ended, undisturbed.run.ended) << "nothing waited for longer";
  ASSERT_EQ(outcome.points.size(), undisturbed.points.size());
  double total_s = 0;
  for (std::size_t i = 0; i < outcome.points.size(); ++i) {
    const auto &is = outcome.points[i], &was = undisturbed.points[i];
    EXPECT_EQ(is.row, was.row);
    EXPECT_EQ(is.measured.utc, was.measured.utc);
    ASSERT_EQ(is.values.size(), was.values.size());
    for (std::size_t k = 0; k < is.values.size(); ++k)
      EXPECT_EQ(is.values[k].value, was.values[k].value) << is.values[k].channel;
  }
  EXPECT_TRUE(std::is_sorted(outcome.time_s.begin(), outcome.time_s.end()));
  EXPECT_EQ(outcome.time_s, undisturbed.time_s);
  EXPECT_EQ(outcome.steps.size(), GetParam().steps_s.size());
  EXPECT_EQ(outcome.alarms.size(), GetParam().steps_s.size());
  for (const double step_s : GetParam().steps_s) total_s += step_s;
  EXPECT_DOUBLE_EQ(seconds_from(outcome.utc_offset), total_s) << "UTC is mapped anew";
  EXPECT_TRUE(undisturbed.steps.empty());
}

INSTANTIATE_TEST_SUITE_P(Steps, WallClockSet,
                         testing::Values(StepCase{"TenMinutesBack", {-600}},
                                         StepCase{"OneHourBack", {-3600}},
                                         StepCase{"OneHourForward", {3600}},
                                         StepCase{"ForwardAndBack", {3600, -3600}},
                                         StepCase{"BackAndForward", {-600, 4200}}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(WallClock, AStepBelowOneSecondIsAnEventWithoutAnAlarm) {
  const auto outcome = run_with({0.25});
  ASSERT_EQ(outcome.steps.size(), 1u);
  EXPECT_THAT(outcome.steps[0], HasSubstr("set forward by 0.250 s"));
  EXPECT_TRUE(outcome.alarms.empty());
}

TEST(WallClock, WhatWasBeforeAStepKeepsItsUtcAcrossARestart) {
  Folder folder;
  SmallWorld world;
  CellTime early;
  {
    CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite);
    cell.pass(10);
    early = cell.now();
    cell.pass(10);
    cell.time().wall_clock_set = std::chrono::seconds(-600);
    cell.pass(10);
    EXPECT_EQ(cell->host.utc(early).ns, early.utc_ns);
  }
  CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite,
                    kWorldBegin + std::chrono::hours(1));
  EXPECT_EQ(cell->host.utc(early).ns, early.utc_ns);
  EXPECT_EQ(cell->host.utc(cell->host.cell_time(cell->host.utc(early))), cell->host.utc(early));
  EXPECT_EQ(cell.events_named("clock.stepped").size(), 2u)
      << "and the clock that was put right while the daemon was away";
}

TEST(WallClock, InASupportBundleTimesAreUtc) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite);
  cell.pass(10);
  cell.time().wall_clock_set = std::chrono::hours(-1);
  cell.pass(10);
  ASSERT_TRUE(cell.await(cell->queue.hold(cell.ada, "after the step")));
  cell.pass(5);
  const auto bytes = cell.await(cell->support.make(cell.ada));
  ASSERT_TRUE(bytes) << bytes.error().message;
  const std::string tar = *formats::gunzip(*bytes, "bundle", 64U << 20U);
  const auto hour_of = [](UtcTime utc) { return to_iso8601(utc).substr(0, 14); };
  const std::string utc = hour_of(cell->host.utc(cell.now()));
  const std::string cell_time = hour_of(UtcTime{cell.now().utc_ns});
  ASSERT_NE(utc, cell_time);
  const auto end_of_line = tar.find("after the step");
  ASSERT_NE(end_of_line, std::string::npos);
  const auto line = tar.rfind('\n', end_of_line) + 1;
  EXPECT_THAT(tar.substr(line, end_of_line - line), HasSubstr(" " + utc));
  EXPECT_THAT(tar, HasSubstr("' at " + utc)) << "the cell's state";
}

// Issue 11, number 12: each device's clock has a measured offset.
TEST(DeviceClockSet, RepeatsThePointUnderWayAndTheRunContinues) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell(folder / "cell.sqlite"), kSqlite);
  const auto id = cell.begin_run(kClockRows).id;
  cell.until([&] { return cell.status().run->run.accepted == 3; }, 3600);
  cell.until([&] { return cell.status().run->phase == "reading"; }, 60);
  world.laser_clock_jump_s = 3600;
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(ended.accepted, ended.rows);
  int interrupted = 0;
  const auto attempts = *cell.await(cell.attempts(id));
  for (const auto& attempt : attempts) interrupted += attempt.verdict == Verdict::interrupted;
  EXPECT_EQ(interrupted, 1);
  cell.pass(10);
  const auto jumps = cell.events_named("device.clock_jumped");
  ASSERT_EQ(jumps.size(), 1u);
  EXPECT_THAT(jumps[0], HasSubstr("laser-x was set by +3600.000 s"));
  int told = 0;
  const auto alarms = *cell.await(cell->alarms.list(false, 100));
  for (const auto& alarm : alarms)
    if (alarm.kind == "device.clock") {
      ++told;
      EXPECT_THAT(alarm.message, HasSubstr("3600.0 s ahead of"));
    }
  EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace driftwise::tests
