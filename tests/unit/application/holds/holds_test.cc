// A run in a cell with limits: it waits, goes on by itself, marks what it measured meanwhile, and
// never ends what a person has set.

#include "server/application/holds/holds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "server/formats/cell_file/cell_file_holds.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::Not;
using testing::SizeIs;

CellDescription cell_with(const std::string& database, HoldAction action, double for_s = 0) {
  auto cell = small_cell(database);
  HoldRule rule;
  rule.name = "support";
  rule.channel = "support_degC";
  rule.above = 23.5;
  rule.release_above = 23.3;
  rule.for_s = for_s;
  rule.settle_s = 300;
  rule.action = action;
  rule.advice = "look at the fan";
  cell.holds = {rule};
  // The small world has no noise of its own.
  ChannelLimitDescription never_frozen;
  never_frozen.channel = "support_degC";
  never_frozen.frozen_answers = 0;
  cell.plausibility.limits.push_back(never_frozen);
  return cell;
}

class Holds : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  const std::string trajectory = lines_of(8, {2, -3, 1}, true);

  RunRecord run(const CellInMemory& cell) { return cell.status().run->run; }
  void begin_and_accept(CellInMemory& cell, int count) {
    cell.begin_run(trajectory);
    cell.until([&] { return run(cell).accepted == count; });
  }
  void until_it_waits(CellInMemory& cell) {
    cell.until([&] { return run(cell).state == RunState::waiting; }, 300);
  }
  void expect_every_row_once(CellInMemory& cell, const RunRecord& ended) {
    EXPECT_EQ(ended.state, RunState::done) << ended.reason;
    const auto points = *cell.await(cell.points(ended.id, 0, 1000));
    ASSERT_THAT(points, SizeIs(32));
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(points[i].row, static_cast<std::int64_t>(i));
  }
};

TEST_F(Holds, WaitsWithTheReasonAndGoesOnByItself) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::finish_point), kSqlite};
  begin_and_accept(cell, 3);
  world.support_set_degc = 25;
  until_it_waits(cell);
  EXPECT_EQ(run(cell).hold.kind, RunHold::Kind::condition);
  EXPECT_THAT(
      run(cell).reason,
      MatchesRegex("support_degC is 23[.].*, limit 23[.]5 .hold support.: look at the fan"));
  const auto moves = world.moves;
  cell.pass(7200);
  EXPECT_EQ(world.moves, moves);
  EXPECT_THAT(cell.alarms_of("run.waiting"), SizeIs(1));
  world.support_set_degc = 23.4;  // below the limit, above the release
  cell.pass(3600);
  EXPECT_EQ(run(cell).state, RunState::waiting);
  world.support_set_degc = 23;
  cell.pass(250);
  EXPECT_EQ(run(cell).state, RunState::waiting);
  cell.until([&] { return run(cell).state == RunState::running; }, 120);
  expect_every_row_once(cell, cell.finish_run());
  EXPECT_THAT(cell.events_named("hold.begun"), SizeIs(1));
  EXPECT_THAT(cell.events_named("hold.ended"), SizeIs(1));
}

TEST_F(Holds, APersonsPauseOutlivesTheCondition) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::finish_point), kSqlite};
  begin_and_accept(cell, 2);
  world.support_set_degc = 25;
  until_it_waits(cell);
  const auto id = run(cell).id;
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, id)));
  cell.until([&] { return run(cell).state == RunState::paused; }, 60);
  world.support_set_degc = 23;
  cell.pass(3600);
  EXPECT_EQ(run(cell).state, RunState::paused);
  EXPECT_EQ(run(cell).reason, "paused by ada");
  ASSERT_TRUE(cell.resume());
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, AResumeUnderAnExceededLimitMovesNothing) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::finish_point, 600),
                    kSqlite};
  begin_and_accept(cell, 2);
  const auto id = run(cell).id;
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, id)));
  cell.until([&] { return run(cell).state == RunState::paused; }, 120);
  world.support_set_degc = 25;
  cell.pass(60);  // less than for_s
  const auto moves = world.moves;
  ASSERT_TRUE(cell.resume());
  until_it_waits(cell);
  cell.pass(1000);
  EXPECT_EQ(world.moves, moves);
  const auto again = cell.resume();
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().reason, "HELD_BY_CELL");
  EXPECT_THAT(again.error().message, HasSubstr("hold aside"));
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, AResumeUnderAnExceededLimitAfterALossOfPowerIsNotAskedForAgain) {
  const auto description = cell_with(folder / "cell.sqlite", HoldAction::finish_point);
  CellInMemory::Further after_power;
  {
    CellInMemory cell{world, description, kSqlite};
    begin_and_accept(cell, 3);
    ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run(cell).id)));
    cell.until([&] { return run(cell).state == RunState::paused; });
    after_power.begin = cell.now() + std::chrono::minutes(10);
    after_power.boot_id = "second";
  }
  world.referenced = false;
  world.support_set_degc = 25;
  const int homes = world.homes, moves = world.moves;
  CellInMemory cell{world, description, kSqlite, std::move(after_power)};
  cell.until([&] { return cell.status().run && cell.status().run->phase == "paused"; });
  cell.pass(3600);
  ASSERT_TRUE(cell.resume());
  cell.until([&] { return run(cell).hold.kind == RunHold::Kind::condition; });
  cell.pass(7200);
  EXPECT_EQ(world.homes + world.moves, homes + moves);
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
  EXPECT_EQ(world.homes, homes + 1);
}

TEST_F(Holds, MarksThePointsMeasuredSinceTheLimitWasExceededFirst) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::finish_point, 45),
                    kSqlite};
  begin_and_accept(cell, 2);
  world.support_set_degc = 25;
  until_it_waits(cell);
  const auto id = run(cell).id;
  const auto now = cell.now();
  const auto readings = *cell.await(cell.read([now](Store& store) {
    return store.readings().readings("support", CellTime{0}, now, 100'000);
  }));
  const auto first = std::ranges::find_if(
      readings, [](const Reading& one) { return *one.find("support_degC") > 23.5; });
  ASSERT_NE(first, readings.end());
  std::set<std::int64_t> expected, marked;
  const auto points = *cell.await(cell.points(id, 0, 1000));
  for (const auto& point : points)
    if (point.measured.utc >= first->end) expected.insert(point.row);
  ASSERT_FALSE(expected.empty());
  const auto marks =
      *cell.await(cell.read([id](Store& store) { return store.remarks().exclusions(id); }));
  for (const auto& mark : marks) {
    EXPECT_TRUE(mark.suspect);
    EXPECT_THAT(mark.reason, HasSubstr("hold support"));
    marked.insert(mark.rows.begin(), mark.rows.end());
  }
  EXPECT_EQ(marked, expected);
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
}

// The value is beyond the limit while a row dwells, and within it again before the row is measured.
TEST_F(Holds, MarksThePointsOfAHoldThatEndsWithinOneVisit) {
  auto description = cell_with(folder / "cell.sqlite", HoldAction::finish_point, 60);
  description.holds.front().settle_s = 120;
  CellInMemory cell{world, description, kSqlite};
  const auto id = cell.begin_run(
                          "q1_mm,set,line,zero,dwell_s\n"
                          "0,calibration,0,1,0\n1,calibration,0,0,0\n"
                          "2,calibration,0,0,0\n3,calibration,0,0,900\n"
                          "-1,calibration,0,0,0\n0,calibration,0,1,0\n")
                      .id;
  cell.until([&] { return run(cell).accepted == 1; });
  world.support_degc = world.support_set_degc = 24;
  cell.until([&] { return run(cell).accepted == 3; });
  cell.pass(90);
  world.support_degc = world.support_set_degc = 23;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(cell.events_named("hold.ended"), SizeIs(1));
  const auto marked = cell.await(cell->annotations.exclusions(id))->suspect_rows;
  EXPECT_THAT(marked, Contains(2)) << "measured beyond the limit, before for_s had passed";
  EXPECT_THAT(marked, Not(Contains(3))) << "measured after the hold";
  EXPECT_THAT(marked, Not(Contains(0)));
}

TEST_F(Holds, ReturnsToZeroBeforeItWaitsWhereTheRuleSaysSo) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::return_to_zero), kSqlite};
  begin_and_accept(cell, 2);
  world.support_set_degc = 25;
  until_it_waits(cell);
  EXPECT_NEAR(world.to_mm, 0, 1e-3);
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, StopsTheAxesAtOnceWhereTheRuleSaysSo) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::stop), kSqlite};
  begin_and_accept(cell, 2);
  cell.until([&] { return cell.status().run->phase == "moving"; });
  const auto stops = world.stops;
  world.support_set_degc = 25;
  until_it_waits(cell);
  EXPECT_GT(world.stops, stops);
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, ItsEndIsNoPermissionToSwitchAServoOn) {
  auto description = cell_with(folder / "cell.sqlite", HoldAction::stop);
  description.holds.front().settle_s = 0;
  CellInMemory cell{world, description, kSqlite};
  begin_and_accept(cell, 3);
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run(cell).id)));
  cell.until([&] { return run(cell).state == RunState::paused; });
  ASSERT_TRUE(cell.resume());
  cell.until([&] { return run(cell).accepted == 6; });
  world.support_degc = world.support_set_degc = 24;
  until_it_waits(cell);
  cell.pass(0.5);
  world.servo_on = false;
  cell.pass(60);
  const auto homes = world.homes, moves = world.moves;
  world.support_degc = world.support_set_degc = 23;
  cell.pass(600);
  EXPECT_FALSE(world.servo_on);
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(world.moves, moves);
  ASSERT_TRUE(cell.resume());
  expect_every_row_once(cell, cell.finish_run());
}

// The cell stops the axes of the run; those of a paused one are lent to the person.
TEST_F(Holds, AStopLeavesTheMovementOfAPersonBesideAPausedRunAlone) {
  auto description = cell_with(folder / "cell.sqlite", HoldAction::stop);
  description.holds.front().settle_s = 0;
  CellInMemory cell{world, description, kSqlite};
  begin_and_accept(cell, 1);
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run(cell).id)));
  cell.until([&] { return run(cell).state == RunState::paused; });
  const auto lease = cell.lease();
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, lease, {4.9}, cell.answer())));
  const auto stops = world.stops, moves = world.moves;
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, lease, {-4.9}, cell.answer()), moved);
  cell.until([&] { return world.moves > moves; });
  // Slowly: the limit is exceeded on the way.
  world.move_end_ns = world.move_begin_ns + nanoseconds_from_s(30).count();
  world.support_degc = world.support_set_degc = 24;
  cell.until(
      [&] { return cell->holds.list().front().phase == application::HoldWatch::Phase::holding; });
  ASSERT_FALSE(moved) << "the axis is on its way";
  cell.until([&] { return moved.has_value(); });
  EXPECT_TRUE(*moved) << moved->error().message;
  EXPECT_NEAR(world.to_mm, -4.9, 1e-3);
  EXPECT_EQ(world.stops, stops);
  EXPECT_EQ(run(cell).state, RunState::paused);
  world.support_degc = world.support_set_degc = 23;
  cell.pass(60);
  ASSERT_TRUE(cell.resume());
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, ALimitThatIsSetAsideSuspendsNothingAndIsOnRecord) {
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::finish_point), kSqlite};
  begin_and_accept(cell, 2);
  world.support_set_degc = 25;
  until_it_waits(cell);
  EXPECT_EQ(cell.await(cell->holds.set_aside(cell.ada, "room", 60, "why")).error().reason,
            "NO_SUCH_HOLD");
  EXPECT_EQ(cell.await(cell->holds.set_aside(cell.ada, "support", 60, " ")).error().reason,
            "REASON_MISSING");
  EXPECT_EQ(cell.await(cell->holds.set_aside(cell.ada, "support", 1e9, "why")).error().reason,
            "BAD_DURATION");
  const auto aside =
      cell.await(cell->holds.set_aside(cell.ada, "support", 36'000, "the fan is being mended"));
  ASSERT_TRUE(aside);
  EXPECT_EQ(aside->aside_by, "ada");
  expect_every_row_once(cell, cell.finish_run());
  EXPECT_THAT(cell.events_named("hold.set_aside"),
              ElementsAre("ada sets hold support aside for 36000 s: the fan is being mended"));
}

TEST_F(Holds, AfterAKillTheLimitIsLookedAtBeforeAnythingMoves) {
  const auto description = cell_with(folder / "cell.sqlite", HoldAction::finish_point, 600);
  CellTime later;
  {
    CellInMemory cell{world, description, kSqlite};
    begin_and_accept(cell, 3);
    cell.shut_down();
    later = cell.now() + nanoseconds_from_s(60);
  }
  world.support_degc = world.support_set_degc = 24;
  const auto moves = world.moves;
  CellInMemory cell{world, description, kSqlite, later};
  cell.until([&] { return cell.status().run && run(cell).state == RunState::waiting; }, 300);
  cell.pass(1800);
  EXPECT_EQ(world.moves, moves);
  world.support_set_degc = 23;
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, AStabiliserThatLeavesItsBandSuspendsTheRunByDefault) {
  auto description = small_cell(folder / "cell.sqlite");
  formats::add_holds_of_stabilisers(description);
  CellInMemory cell{world, description, kSqlite};
  begin_and_accept(cell, 3);
  world.support_set_degc = 23.5;  // somebody at the device; it follows slowly
  until_it_waits(cell);
  EXPECT_THAT(run(cell).reason, HasSubstr("hold stabiliser-support"));
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, ALowBatteryEndsTheDaemonOnceAndTheRunGoesOnWithTheNextStart) {
  const auto description = cell_with(folder / "cell.sqlite", HoldAction::end_daemon);
  int asked = 0;
  CellTime later;
  {
    CellInMemory cell{world, description, kSqlite,
                      CellInMemory::Further{.end_daemon = [&asked] { ++asked; }}};
    begin_and_accept(cell, 3);
    const auto stops = world.stops;
    world.support_set_degc = 25;
    until_it_waits(cell);
    cell.pass(600);
    EXPECT_EQ(asked, 1);
    EXPECT_GT(world.stops, stops);
    EXPECT_THAT(cell.events_named("hold.ends_daemon"), SizeIs(1));
    cell.shut_down();
    later = cell.now() + nanoseconds_from_s(3600);
  }
  world.support_degc = world.support_set_degc = 23;
  CellInMemory cell{world, description, kSqlite, later};
  cell.until([&] { return cell.status().run.has_value(); }, 300);
  expect_every_row_once(cell, cell.finish_run());
}

TEST_F(Holds, AMissingValueSuspendsARunAndEndsNoDaemon) {
  int asked = 0;
  CellInMemory cell{world, cell_with(folder / "cell.sqlite", HoldAction::end_daemon), kSqlite,
                    CellInMemory::Further{.end_daemon = [&asked] { ++asked; }}};
  begin_and_accept(cell, 3);
  world.support_away = true;
  until_it_waits(cell);
  EXPECT_THAT(run(cell).reason, HasSubstr("support_degC has no fresh value"));
  cell.pass(7200);
  EXPECT_EQ(asked, 0);
  world.support_away = false;
  expect_every_row_once(cell, cell.finish_run());
  EXPECT_EQ(asked, 0);
}

TEST_F(Holds, WithoutRulesNothingIsListed) {
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  EXPECT_THAT(cell->holds.list(), IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
