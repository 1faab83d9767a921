// What moves a robot that people have stopped, and what does not.

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using application::Caller;
using application::HoldAnswer;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class AtTheMachine : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  const Caller bob{"bob", "ipv4:127.0.0.1:5021", {}};
  const std::string trajectory = lines_of(2, {2, -3, 1}, true);

  RunId begin_and_accept(int count) {
    const auto run = cell.begin_run(trajectory);
    cell.until([&] { return cell.status().run->run.accepted == count; });
    return run.id;
  }
  void until_paused() {
    cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  }
  std::vector<std::string> alarms(const std::string& kind) { return cell.alarms_of(kind); }
};

// Scripts pause and resume faster than a point is measured.
TEST_F(AtTheMachine, ResumeEndsAPauseBeforeThePointUnderWayIsThrough) {
  const RunId run = begin_and_accept(2);
  const auto asked = cell.await(cell->runs.pause(cell.ada, run));
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->state, RunState::running) << "the point under way is not through yet";
  EXPECT_EQ(asked->hold.who, "ada");
  const auto seen = cell.await(cell->runs.get(run));
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->hold, asked->hold);
  EXPECT_EQ(cell.await(cell->runs.resume(bob, run, {})).error().reason, "HOLD_NOT_NAMED");
  const auto resumed = cell.await(cell->runs.resume(bob, run, {seen->hold.id(), {}}));
  ASSERT_TRUE(resumed) << resumed.error().message;
  EXPECT_EQ(cell.await(cell->runs.get(run))->hold.kind, RunHold::Kind::none);
  bool was_paused = false;
  const auto watch = cell->runs.watch([&was_paused](const application::RunProgress& progress) {
    was_paused = was_paused || progress.run.state == RunState::paused;
  });
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_FALSE(was_paused);
}

TEST_F(AtTheMachine, ResumeNamesThePauseThatItEnds) {
  const RunId run = begin_and_accept(2);
  EXPECT_EQ(cell.await(cell->runs.resume(cell.ada, run, {})).error().reason, "NOT_PAUSED");
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
  until_paused();
  const auto first = cell.answer();
  EXPECT_EQ(cell.status().run->run.hold.who, "ada");
  cell.pass(720);
  const auto unnamed = cell.await(cell->runs.resume(bob, run, {}));
  ASSERT_FALSE(unnamed);
  EXPECT_EQ(unnamed.error().reason, "HOLD_NOT_NAMED");
  EXPECT_THAT(unnamed.error().message, HasSubstr("run 1 was paused by ada 12 min ago"));
  // A pause is ended by anybody who names it, and by nobody twice.
  ASSERT_TRUE(cell.await(cell->runs.resume(bob, run, first)));
  cell.until([&] { return cell.status().run->run.state == RunState::running; });
  EXPECT_EQ(cell.status().run->run.hold.kind, RunHold::Kind::none);
  ASSERT_TRUE(cell.await(cell->runs.pause(bob, run)));
  until_paused();
  EXPECT_EQ(cell.await(cell->runs.resume(cell.ada, run, first)).error().reason, "HOLD_NOT_NAMED")
      << "that was another pause";
  EXPECT_THAT(cell.events_named("run.resume").front(),
              HasSubstr("resumed by bob: run 1 was paused by ada 12 min ago"));
}

TEST_F(AtTheMachine, AStopIsEndedByTheSameNameOrWithAReasonInWriting) {
  const RunId run = begin_and_accept(2);
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  until_paused();
  EXPECT_EQ(cell.status().run->run.hold.kind, RunHold::Kind::stop);
  const auto refused = cell.resume(bob);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "STOPPED_BY_ANOTHER");
  EXPECT_THAT(refused.error().message, HasSubstr("stopped by ada"));
  EXPECT_EQ(cell.resume(bob, "  ").error().reason, "STOPPED_BY_ANOTHER") << "blanks are no reason";
  // A pause on top of it makes it no weaker.
  ASSERT_TRUE(cell.await(cell->runs.pause(bob, run)));
  EXPECT_EQ(cell.resume(bob).error().reason, "STOPPED_BY_ANOTHER");
  ASSERT_TRUE(cell.resume(bob, "ada went home, the door is closed"));
  EXPECT_THAT(cell.events_named("run.resume").front(),
              HasSubstr("overridden: ada went home, the door is closed"));
  cell.until([&] { return cell.status().run->run.accepted == 4; });
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  until_paused();
  EXPECT_TRUE(cell.resume(cell.ada)) << "the same name";
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(AtTheMachine, AStopIsInTheLogOfTheRun) {
  const RunId run = begin_and_accept(1);
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  const auto events = *cell.await(cell.events(EventId{0}, 1000));
  const auto stop = std::find_if(events.begin(), events.end(),
                                 [](const auto& one) { return one.what == "stop"; });
  ASSERT_NE(stop, events.end());
  EXPECT_EQ(stop->run, run);
}

TEST_F(AtTheMachine, TheAxesMayBeMovedInAPausedRunByWhoMayEndThePause) {
  const RunId run = begin_and_accept(3);
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1})).error().reason,
            "RUN_UNDER_WAY");
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  until_paused();
  cell.pass(5);
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1.5}, {})).error().reason,
            "HOLD_NOT_NAMED");
  EXPECT_EQ(cell.await(cell->manual.home(bob, cell.lease(), cell.answer())).error().reason,
            "STOPPED_BY_ANOTHER");
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1.5}, cell.answer())));
  EXPECT_NEAR(world.to_mm, 1.5, 1e-3);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused) << "it moves no run on";
  std::optional<Result<void>> homed;
  cell.begin(cell->manual.home(cell.ada, cell.lease(), cell.answer()), homed);
  cell.pass(1);
  EXPECT_EQ(cell.resume().error().reason, "MOVING");
  cell.until([&] { return homed.has_value(); });
  ASSERT_TRUE(*homed) << homed->error().message;
  // It comes to its point anew, with the zero measured again.
  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  const auto data = *cell.await(cell.datums(run));
  ASSERT_THAT(data, SizeIs(2));
  EXPECT_EQ(data[1].reason, "moved by hand");
  EXPECT_THAT(*cell.await(cell.points(run, 0, 100)), SizeIs(8));
}

// Both are asked for in one turn of the executor, before the engine has seen the resume.
TEST_F(AtTheMachine, AResumeAndAMovementInTheSameInstantAreNotBothTaken) {
  const RunId run = begin_and_accept(3);
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
  until_paused();
  cell.pass(10);
  const auto token = cell.lease();
  const auto answer = cell.answer();
  const int homes = world.homes;
  std::optional<Result<RunRecord>> resumed;
  std::optional<Result<void>> homed;
  cell.begin(cell->runs.resume(bob, run, answer), resumed);
  cell.begin(cell->manual.home(cell.ada, token, answer), homed);
  cell.until([&] { return resumed && homed; });
  EXPECT_TRUE(*resumed) << resumed->error().message;
  ASSERT_FALSE(*homed);
  EXPECT_EQ(homed->error().reason, "RUN_UNDER_WAY");
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.homes, homes);
}

// Motion and heat that nobody could tell of afterwards.
TEST_F(AtTheMachine, WhatMovesOrHeatsIsOnRecordFirst) {
  const RunId run = begin_and_accept(3);
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
  until_paused();
  cell.pass(10);
  const auto lease = cell.lease();
  sqlite3* other = nullptr;  // another program that holds the database
  ASSERT_EQ(sqlite3_open((folder / "cell.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const int moves = world.moves;
  const auto resumed = cell.resume();
  ASSERT_FALSE(resumed);
  EXPECT_THAT(resumed.error().message, HasSubstr("another program holds the database"));
  EXPECT_FALSE(cell.await(cell->manual.set_stabiliser(cell.ada, lease, "support", 30)));
  cell.pass(60);
  EXPECT_EQ(world.moves, moves);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  EXPECT_EQ(world.support_set_degc, 23.0);
  ASSERT_EQ(sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(AtTheMachine, PositionsAndLengthsAreSeenBetweenRuns) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1.25})));
  cell.pass(5);
  const auto value_of = [&](const std::string& channel) {
    for (const auto& value : cell.status().values)
      if (value.channel.name() == channel && value.age_s < 5) return value.value;
    return kMissing;
  };
  EXPECT_NEAR(value_of("q1_mm"), 1.25, 1e-3);
  EXPECT_NEAR(value_of("x_mm"), 1.25, 1e-2);
  const auto before = *cell.await(cell.events(EventId{0}, 1000));
  cell.pass(60);
  const auto store = *kSqlite(folder / "cell.sqlite", true);
  EXPECT_THAT(
      *store->readings().readings("axis", cell.now() - std::chrono::seconds(50), cell.now(), 100),
      IsEmpty())
      << "shown, not stored";
}

TEST_F(AtTheMachine, ARunThatGivesUpTooManyRowsIsPaused) {
  auto csv = std::string("q1_mm,set,line,zero\n0,calibration,1,1\n");
  for (int i = 0; i < 40; ++i) csv += std::to_string(0.1 * i) + ",calibration,1,0\n";
  application::CreateRun request;
  request.name = "r";
  request.trajectory_name = "r.csv";
  request.trajectory_text = csv;
  request.rules = small_cell("").run;
  request.rules->max_requeues = 0;
  ASSERT_TRUE(cell.try_run(request));
  cell.until([&] { return cell.status().run->run.accepted == 4; });
  world.disturbed_readings = 1'000'000;
  until_paused();
  EXPECT_EQ(cell.status().run->run.given_up, 5);
  EXPECT_EQ(cell.status().run->run.hold.kind, RunHold::Kind::trouble);
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("of the last 9 rows were given up"));
  world.disturbed_readings = 0;
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done) << "counted anew from there";
}

// -------------------------------------------------------------------------- the end of a run

const std::string kLoaded =
    "q1_mm,set,line,zero,force_N\n"
    "0,calibration,1,1,0\n2,calibration,1,0,2.305\n-3,validation,1,0,2.305\n";

TEST(EndOfARun, TakesTheForceOffAndReturnsToZero) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", true), kSqlite);
  cell.begin_run(kLoaded);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.force_n, 0);
  EXPECT_NEAR(world.to_mm, 0, 1e-3);
}

TEST(EndOfARun, AsksThePersonWhoHungTheWeights) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", false), kSqlite);
  const auto run = cell.begin_run(kLoaded);
  const auto waits = [&] { return cell.status().run->phase == "waiting for a person"; };
  cell.until(waits);
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 0)));
  cell.until([&] { return waits() && cell.status().run->run.accepted == 1; });
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 2.305)));
  cell.until([&] { return waits() && cell.status().run->run.accepted == 3; });
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("take every weight off: 0 N"));
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 0)));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST(EndOfARun, MovesNothingAfterAnAbortAndSaysWhichForceIsOn) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", true), kSqlite);
  const auto run = cell.begin_run(kLoaded);
  cell.until([&] { return cell.status().run->run.accepted == 2; });
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, run.id, "enough")));
  EXPECT_EQ(cell.finish_run().state, RunState::aborted);
  const int moves = world.moves, loads = world.loads;
  cell.pass(600);
  EXPECT_EQ(world.moves, moves);
  EXPECT_EQ(world.loads, loads);
  EXPECT_EQ(world.force_n, 2.305);
  EXPECT_THAT(cell.alarms_of("load.on"), ElementsAre(AllOf(HasSubstr("2.305 N act on the robot"),
                                                           HasSubstr("take every weight off"))));
}

TEST(EndOfARun, StaysWhereItIsWhenTheRuleSaysSo) {
  Folder folder;
  SmallWorld world;
  auto description = small_cell_with_load(folder / "cell.sqlite", true);
  description.run.park = false;
  CellInMemory cell(world, description, kSqlite);
  cell.begin_run(kLoaded);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.force_n, 2.305);
  EXPECT_NEAR(world.to_mm, -3, 1e-3);
}

TEST(Weights, ThatAreHungWhileTheRunIsPausedMoveNothing) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", false), kSqlite);
  const auto run = cell.begin_run(kLoaded);
  const auto waits = [&] { return cell.status().run->phase == "waiting for a person"; };
  for (const double force_n : {0.0, 2.305}) {  // before the zero, and between two rows
    cell.until(waits);
    ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run.id)));
    const int homes = world.homes, moves = world.moves;
    ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, force_n)));
    cell.until([&] { return cell.status().run->run.state == RunState::paused; });
    cell.pass(600);
    EXPECT_EQ(world.homes + world.moves, homes + moves) << force_n << " N";
    ASSERT_TRUE(cell.resume());
    cell.until([&] { return world.moves > moves; });
  }
  cell.until(waits);
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 0)));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST(Weights, ThatStickedAndWereMendedLetTheRunGoOn) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", true), kSqlite);
  world.load_jammed = true;
  cell.begin_run(kLoaded);
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  cell.pass(3600);
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("jammed"));
  world.load_jammed = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done) << "nobody has to say so to the daemon";
}

// -------------------------------------------------------------------------------- a restart

class AfterAwayTest : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellDescription description = small_cell(folder / "cell.sqlite");
  CellTime later = kWorldBegin;
  RunId run;

  // A run that was under way when the daemon ended, with the computer or without.
  void run_is_interrupted() {
    CellInMemory cell(world, description, kSqlite);
    run = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
    cell.until([&] { return cell.status().run->run.accepted == 3; });
    later = cell.now() + std::chrono::minutes(10);
  }
  CellInMemory::Further after(const std::string& boot_id) {
    CellInMemory::Further further;
    further.begin = later;
    further.boot_id = boot_id;
    return further;
  }
};

TEST_F(AfterAwayTest, OfTheDaemonTheRunGoesOnByItself) {
  run_is_interrupted();
  CellInMemory cell(world, description, kSqlite, after("first"));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(cell.events_named("run.moves_soon"), IsEmpty());
}

TEST_F(AfterAwayTest, OfTheDaemonTheRunWaitsWhereTheCellFileSaysSo) {
  description.restart.after_restart = AfterAway::wait;
  run_is_interrupted();
  CellInMemory cell(world, description, kSqlite, after("first"));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("after_restart"));
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(AfterAwayTest, OfTheComputerNothingMovesUntilAPersonResumes) {
  run_is_interrupted();
  const int homes = world.homes, moves = world.moves;
  CellInMemory cell(world, description, kSqlite, after("second"));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(7200);
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(world.moves, moves);
  EXPECT_EQ(cell.status().run->run.hold.kind, RunHold::Kind::restart);
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("the computer was started anew"));
  EXPECT_THAT(cell.events_named("run.restarted"),
              testing::ElementsAre("restart of the computer: row 4 is next"));
  const auto alarms = cell.await(cell->alarms.list(true, 100));
  ASSERT_TRUE(alarms);
  for (const auto& alarm : *alarms) {
    if (alarm.kind != "run.paused") continue;
    EXPECT_EQ(alarm.level, AlarmLevel::warning) << "nobody at home knows that it waits";
  }
  EXPECT_THAT(cell.alarms_of("run.paused"), SizeIs(1));
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(*cell.await(cell.points(run, 0, 100)), SizeIs(8));
}

TEST_F(AfterAwayTest, ALostReferenceCountsAsALossOfPower) {
  run_is_interrupted();
  world.referenced = false;
  const int homes = world.homes;
  CellInMemory cell(world, description, kSqlite, after("first"));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_EQ(world.homes, homes);
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("lost its reference"));
}

TEST_F(AfterAwayTest, GoingOnAfterALossOfPowerIsAnnouncedForAMinute) {
  description.restart.after_power_loss = AfterAway::go_on;
  run_is_interrupted();
  const int homes = world.homes, moves = world.moves;
  CellInMemory cell(world, description, kSqlite, after("second"));
  cell.until([&] { return cell.status().run && cell.status().run->phase == "about to move"; });
  const auto announced = cell.now();
  cell.pass(50);
  EXPECT_EQ(world.homes + world.moves, homes + moves);
  EXPECT_THAT(cell.alarms_of("run.moves_soon"), SizeIs(1));
  cell.until([&] { return world.homes > homes; });
  EXPECT_GE(seconds_from(cell.now() - announced), 60);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(AfterAwayTest, AStopCancelsTheAnnouncedMotion) {
  description.restart.after_power_loss = AfterAway::go_on;
  run_is_interrupted();
  const int homes = world.homes, moves = world.moves;
  CellInMemory cell(world, description, kSqlite, after("second"));
  cell.until([&] { return cell.status().run && cell.status().run->phase == "about to move"; });
  static_cast<void>(cell.await(cell->manual.stop_all({"bob", "peer", {}})));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(7200);
  EXPECT_EQ(world.homes + world.moves, homes + moves);
  EXPECT_EQ(cell.resume().error().reason, "STOPPED_BY_ANOTHER");
}

TEST_F(AfterAwayTest, APauseCancelsTheAnnouncedMotion) {
  description.restart.after_power_loss = AfterAway::go_on;
  run_is_interrupted();
  const int homes = world.homes, moves = world.moves;
  CellInMemory cell(world, description, kSqlite, after("second"));
  cell.until([&] { return cell.status().run && cell.status().run->phase == "about to move"; });
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(7200);
  EXPECT_EQ(world.homes + world.moves, homes + moves);
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(cell.events_named("run.moves_soon"), SizeIs(1)) << "who resumes has asked for it";
}

TEST_F(AfterAwayTest, PausedStaysPausedWithWhoPausedIt) {
  {
    CellInMemory cell(world, description, kSqlite);
    run = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
    cell.until([&] { return cell.status().run->run.accepted == 3; });
    static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
    cell.until([&] { return cell.status().run->run.state == RunState::paused; });
    later = cell.now() + std::chrono::minutes(10);
  }
  CellInMemory cell(world, description, kSqlite, after("second"));
  cell.until(
      [&] { return cell.status().run && cell.status().run->run.hold.kind != RunHold::Kind::none; });
  EXPECT_EQ(cell.status().run->run.hold.who, "ada");
  EXPECT_EQ(cell.resume({"bob", "peer", {}}).error().reason, "STOPPED_BY_ANOTHER");
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

}  // namespace
}  // namespace driftwise::tests
