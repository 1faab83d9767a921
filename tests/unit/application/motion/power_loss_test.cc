// A controller that loses its power before a run has its first datum: who says that it may move.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class BeforeTheFirstDatum : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellDescription description = small_cell(folder / "cell.sqlite");
  std::optional<CellInMemory> daemon;
  const std::string trajectory = lines_of(2, {2, -3, 1}, true);
  int homes = 0, moves = 0;  // so far

  CellInMemory& start(CellTime begin = kWorldBegin) {
    CellInMemory::Further further;
    further.begin = begin;
    daemon.emplace(world, description, kSqlite, std::move(further));
    return *daemon;
  }
  // Ten minutes later, on the same start of the computer.
  CellInMemory& restart() {
    const auto later = daemon->now() + std::chrono::minutes(10);
    daemon.reset();
    return start(later);
  }
  void lose_power() {
    world.referenced = world.servo_on = false;
    homes = world.homes;
    moves = world.moves;
  }
  // It has stood at its zero, and waits there for the stabiliser.
  void begin_run_that_waits() {
    auto& cell = *daemon;
    world.support_degc = 10;
    cell.pass(6);
    cell.begin_run(trajectory);
    cell.until([&] { return cell.status().run->phase == "waiting for the stabiliser"; });
  }
  void expect_a_person_is_asked(const char* why) {
    auto& cell = *daemon;
    cell.until([&] {
      const auto status = cell.status();
      return status.run && status.run->run.state == RunState::paused;
    });
    cell.pass(7200);
    EXPECT_EQ(world.homes, homes);
    EXPECT_EQ(world.moves, moves);
    EXPECT_THAT(cell.status().run->run.reason, HasSubstr(why));
    world.support_degc = 22.99;  // still moving: equal answers for hours would be a fault
    ASSERT_TRUE(cell.resume());
    EXPECT_EQ(cell.finish_run().state, RunState::done);
    EXPECT_GT(world.homes, homes);
  }
};

TEST_F(BeforeTheFirstDatum, ALossOfPowerIsAskedAbout) {
  auto& cell = start();
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  begin_run_that_waits();
  lose_power();
  expect_a_person_is_asked("the servo was switched off");
}

TEST_F(BeforeTheFirstDatum, ALossOfPowerWhileTheDaemonWasAwayIsAskedAbout) {
  auto& cell = start();
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  begin_run_that_waits();
  lose_power();
  restart();
  expect_a_person_is_asked("after_power_loss");
}

// The record has no datum at all, and the run itself has homed the axes.
TEST_F(BeforeTheFirstDatum, ALossOfPowerAfterTheRunHasHomedIsAskedAbout) {
  start();
  begin_run_that_waits();
  ASSERT_EQ(world.homes, 1);
  lose_power();
  restart();
  expect_a_person_is_asked("after_power_loss");
}

TEST_F(BeforeTheFirstDatum, ALossOfPowerWhileAPersonHangsWeightsIsAskedAbout) {
  description = small_cell_with_load(folder / "cell.sqlite", false);
  auto& cell = start();
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  const auto run = cell.begin_run("q1_mm,set,line,zero,force_N\n0,calibration,1,1,2.305\n");
  cell.until([&] { return cell.status().run->phase == "waiting for a person"; });
  lose_power();
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 2.305)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(7200);
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(world.moves, moves);
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("after_power_loss"));
}

TEST_F(BeforeTheFirstDatum, ALossOfPowerIsAnnouncedWhereTheCellFileSaysToGoOn) {
  description.restart.after_power_loss = AfterAway::go_on;
  auto& first = start();
  ASSERT_TRUE(first.await(first->manual.home(first.ada, first.lease())));
  begin_run_that_waits();
  lose_power();
  auto& cell = restart();
  world.support_degc = 22.99;
  cell.until([&] {
    const auto status = cell.status();
    return status.run && status.run->phase == "about to move";
  });
  const auto announced = cell.now();
  cell.until([&] { return world.homes > homes; });
  EXPECT_GE(seconds_from(cell.now() - announced), 60);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

// Nobody knows how the axes were when the person asked.
TEST_F(BeforeTheFirstDatum, AControllerThatWasAwayFromTheBeginningIsAskedAbout) {
  auto& cell = start();
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  world.axis_away = true;
  cell.pass(10);
  cell.begin_run(trajectory);
  cell.pass(3600);
  lose_power();
  world.axis_away = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(7200);
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(world.moves, moves);
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

// A person has asked for motion of axes that come so from their power supply.
TEST_F(BeforeTheFirstDatum, AxesWithoutAReferenceWhenThePersonAskedAreHomedAfterARestart) {
  auto& cell = start();
  lose_power();
  world.scanner_away = true;
  cell.begin_run(trajectory);
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  EXPECT_EQ(world.homes, 0);
  auto& again = restart();
  world.scanner_away = false;
  EXPECT_EQ(again.finish_run().state, RunState::done);
  EXPECT_THAT(again.events_named("run.moves_soon"), IsEmpty());
}

TEST_F(BeforeTheFirstDatum, ThePermissionToHomeIsUsedUpByAHomingThatSucceeds) {
  auto& cell = start();
  lose_power();
  cell.begin_run(trajectory);
  for (int breaks = 0; breaks < 3; ++breaks) {
    cell.until([&] { return cell.status().run->phase == "homing"; });
    world.axis_away = true;
    cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
    cell.pass(600);
    EXPECT_EQ(world.homes, 0);
    world.axis_away = false;
  }
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.homes, 1);
}

}  // namespace
}  // namespace driftwise::tests
