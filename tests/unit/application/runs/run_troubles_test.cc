// Devices that go away and come back, people who pause, abort and stop.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class RunTroubles : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  const std::string trajectory = lines_of(2, {2, -3, 1}, true);

  void begin_and_accept(int count) {
    cell.begin_run(trajectory);
    cell.until([&] { return cell.status().run->run.accepted == count; });
  }
  RunId run() { return cell.status().run->run.id; }
  void expect_waiting() {
    cell.until([&] { return cell.status().run->run.state == RunState::waiting; }, 120);
    EXPECT_FALSE(cell.status().run->run.reason.empty());
  }
  // Every row has its point, once.
  void expect_complete(const RunRecord& ended) {
    EXPECT_EQ(ended.state, RunState::done) << ended.reason;
    const auto points = *cell.await(cell.points(ended.id, 0, 1000));
    ASSERT_EQ(points.size(), 8u);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(points[i].row, static_cast<std::int64_t>(i));
  }
};

TEST_F(RunTroubles, WaitsForALostControllerAndGoesOnByItself) {
  begin_and_accept(3);
  world.axis_away = true;
  expect_waiting();
  cell.pass(300);
  world.axis_away = false;
  expect_complete(cell.finish_run());
  EXPECT_EQ(world.zeroings, 1);  // the reference was kept: no new datum
  EXPECT_EQ(cell.events_named("device.lost").size(), 1u);
  EXPECT_EQ(cell.events_named("device.back").size(), 1u);
}

TEST_F(RunTroubles, ADeviceIsBackByAnAnswerAndNotByAnExchangeThatIsCutOff) {
  world.scanner_away = true;
  cell.until([&] { return cell.events_named("device.lost").size() == 1; });
  world.cut = true;
  cell.pass(60);
  EXPECT_EQ(cell.events_named("device.back").size(), 0u);
  EXPECT_EQ(cell.events_named("device.lost").size(), 1u);  // nor is any other lost by it
  world.cut = world.scanner_away = false;
  cell.until([&] { return cell.events_named("device.back").size() == 1; });
}

TEST_F(RunTroubles, AsksAPersonThenHomesAndOpensADatumWhenTheReferenceWasLost) {
  begin_and_accept(3);
  const int homes = world.homes, moves = world.moves;
  world.axis_away = true;
  expect_waiting();
  world.referenced = false;
  world.axis_away = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_THAT(cell.status().run->run.reason,
              testing::HasSubstr("lost its reference while the run was under way"));
  cell.pass(3600);
  EXPECT_EQ(world.homes + world.moves, homes + moves) << "an unexpected start must be chosen";
  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  expect_complete(ended);
  EXPECT_EQ(world.homes, homes + 1);
  const auto data = *cell.await(cell.datums(ended.id));
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[1].reason, "reference lost");
}

TEST_F(RunTroubles, OpensADatumWhenTheBeamWasLost) {
  begin_and_accept(3);
  world.beam_lost = true;
  const auto ended = cell.finish_run();
  expect_complete(ended);
  const auto data = *cell.await(cell.datums(ended.id));
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[1].reason, "beam lost");
  const auto points = *cell.await(cell.points(ended.id, 0, 1000));
  EXPECT_EQ(points.front().datum, data[0].id);
  EXPECT_EQ(points.back().datum, data[1].id);
  bool interrupted = false;
  const auto all_attempts = *cell.await(cell.attempts(ended.id));
  for (const auto& attempt : all_attempts) interrupted |= attempt.verdict == Verdict::interrupted;
  EXPECT_TRUE(interrupted);
}

TEST_F(RunTroubles, WaitsForALostInterferometer) {
  begin_and_accept(2);
  world.laser_away = true;
  expect_waiting();
  EXPECT_GE(world.stops, 1);
  world.laser_away = false;
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, TakesNoPointWithTemperaturesThatAreTooOld) {
  begin_and_accept(2);
  world.scanner_away = true;
  expect_waiting();
  EXPECT_NE(cell.status().run->run.reason.find("too old"), std::string::npos);
  EXPECT_LE(cell.status().run->run.accepted, 5);
  world.scanner_away = false;
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, WaitsForABrokenProbe) {
  begin_and_accept(2);
  world.probe_broken = true;
  expect_waiting();
  EXPECT_NE(cell.status().run->run.reason.find("t03_degC"), std::string::npos);
  world.probe_broken = false;
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, HoldsForAPersonAfterAnEmergencyStop) {
  begin_and_accept(2);
  world.halted = true;
  expect_waiting();
  const auto accepted = cell.status().run->run.accepted;
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.accepted, accepted);
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  ASSERT_TRUE(cell.resume());
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, PausesAfterThePresentPointAndResumes) {
  begin_and_accept(2);
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run())));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_EQ(cell.status().run->run.reason, "paused by ada");
  const auto accepted = cell.status().run->run.accepted;
  EXPECT_EQ(accepted, 3);  // the point under way was finished
  cell.pass(1000);
  EXPECT_EQ(cell.status().run->run.accepted, accepted);
  ASSERT_TRUE(cell.resume());
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, AbortsWithTheReasonAndKeepsWhatWasMeasured) {
  begin_and_accept(2);
  const auto id = run();
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, id, "wrong mirror")));
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::aborted);
  EXPECT_EQ(ended.reason, "aborted by ada: wrong mirror");
  EXPECT_EQ(cell.await(cell.points(id, 0, 100))->size(), 2u);
  EXPECT_FALSE(cell.await(cell->runs.resume(cell.ada, id, {})));
  // The cell is free for the next run.
  cell.begin_run(trajectory);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(RunTroubles, StopAllHaltsTheAxisAtOnceAndNeedsNoLease) {
  begin_and_accept(2);
  cell.until([&] { return cell.status().run->phase == "moving"; });
  const int stops = world.stops;
  EXPECT_TRUE(cell.await(cell->manual.stop_all({"bob", "peer", {}}))->confirmed);
  EXPECT_GT(world.stops, stops);
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_EQ(cell.status().run->run.reason, "stopped by bob");
  EXPECT_EQ(cell.status().run->run.accepted, 2);  // unlike a pause, the point was not finished
  cell.pass(1000);
  EXPECT_EQ(cell.status().run->run.accepted, 2);
  ASSERT_TRUE(cell.resume({"bob", "peer", {}}));
  expect_complete(cell.finish_run());
  EXPECT_EQ(world.zeroings, 1);  // one slip costs one attempt, not the zero
}

TEST_F(RunTroubles, StopAllHoldsARunThatWaitsForADevice) {
  begin_and_accept(2);
  world.axis_away = true;
  expect_waiting();
  // He hears that the axis is away, and the stop stays pending until it is back.
  EXPECT_FALSE(cell.await(cell->manual.stop_all({"bob", "peer", {}}))->confirmed);
  cell.pass(60);
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  EXPECT_EQ(cell.status().pending_stops.size(), 1u);
  world.axis_away = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  // Stopped once more while it stands, it stands on, with who was last.
  ASSERT_TRUE(cell.await(cell->manual.stop_all({"eve", "peer", {}})));
  cell.until([&] { return cell.status().run->run.reason == "stopped by eve"; });
  ASSERT_TRUE(cell.resume({"eve", "peer", {}}));
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, AStoppedRunCanBeAborted) {
  begin_and_accept(2);
  ASSERT_TRUE(cell.await(cell->manual.stop_all({"bob", "peer", {}})));
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, run(), "enough")));
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::aborted);
  EXPECT_EQ(ended.reason, "aborted by ada: enough");
}

TEST_F(RunTroubles, ShutDownLeavesTheRunToTheNextStart) {
  begin_and_accept(3);
  const auto id = run();
  cell.shut_down();
  auto store = *kSqlite(folder / "cell.sqlite", true);
  EXPECT_FALSE(is_over(store->runs().run(id)->state));
  ASSERT_TRUE(*store->runs().unfinished_run());
}

// The laser goes in the middle of a run: the run waits, nothing else is wrong.
TEST_F(RunTroubles, ADeviceThatIsLostIsOneAlarmAndTheRunThatWaitsStandsUnderIt) {
  begin_and_accept(3);
  world.laser_away = true;
  expect_waiting();
  cell.pass(60);
  for (const auto& device : cell.status().devices) {
    const bool is_lost = device.description.id == "laser-x";
    EXPECT_EQ(device.health.link == LinkState::failed, is_lost) << device.description.id;
  }
  const auto alarms = cell.await(cell->alarms.list(false, 100));
  ASSERT_TRUE(alarms);
  ASSERT_EQ(alarms->size(), 1u);
  EXPECT_EQ(alarms->front().kind, "device.lost");
  EXPECT_EQ(alarms->front().subject, "laser-x");
  EXPECT_THAT(alarms->front().consequences, testing::Contains(testing::HasSubstr("run 1 waits")));
  world.laser_away = false;
  expect_complete(cell.finish_run());
}

TEST_F(RunTroubles, BeforeTheStartLeaveTheDriftToBeChecked) {
  world.warming_k_per_h = 100;  // 250 nm/min
  world.scanner_away = true;
  cell.begin_run(trajectory);
  expect_waiting();
  world.scanner_away = false;
  cell.pass(200);
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  EXPECT_THAT(cell.status().run->run.reason, testing::HasSubstr("the zero drifts by"));
  EXPECT_EQ(world.zeroings, 0) << "no datum is opened in a cell that drifts";
}

// 5 um, while the axes are on their way back from the last line.
TEST_F(RunTroubles, AStopInTheLastReturnToZeroLeavesItOwed) {
  world.warming_k_per_h = 0;
  const auto id = cell.begin_run(lines_of(1, {1, 2, -1}, false)).id;
  cell.until([&] {
    const auto run = *cell.status().run;
    return run.run.accepted == 3 && run.phase == "moving";
  });
  world.zero_mm += 0.005;
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(20);
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto closures =
      *cell.await(cell.read([id](Store& store) { return store.closures().closures(id); }));
  ASSERT_EQ(closures.size(), 1u);
  EXPECT_EQ(closures.front().decision, ClosureDecision::new_datum);
  EXPECT_EQ(cell.await(cell->annotations.exclusions(id))->suspect_rows.size(), 3u);
}

}  // namespace
}  // namespace driftwise::tests
