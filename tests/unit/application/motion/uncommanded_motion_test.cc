// Motion that the daemon did not command: an alarm, a point that is not accepted, a run that waits
// for a person and then measures its zero again.

#include <gmock/gmock.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class UncommandedMotion : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};

  // Somebody else moves the axis: at once, as far as the daemon can see.
  void push(double by_mm) {
    world.from_mm = world.to_mm = world.to_mm + by_mm;
    world.move_end_ns = 0;
  }
  std::vector<std::string> alarms(const std::string& kind) { return cell.alarms_of(kind); }
  void pause_and_resume(RunId run) {
    ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
    cell.until([&] { return cell.status().run->run.state == RunState::paused; });
    ASSERT_TRUE(cell.resume());
    cell.until([&] { return cell.status().run->run.state == RunState::running; });
  }
  void until_waiting() {
    cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  }
  void expect_that_nobody_switches_it_on() {
    const auto homes = world.homes, moves = world.moves;
    cell.pass(600);
    EXPECT_NE(cell.status().run->run.state, RunState::running);
    EXPECT_THAT(cell.status().run->run.reason, HasSubstr("servo"));
    EXPECT_FALSE(world.servo_on);
    EXPECT_EQ(world.homes, homes);
    EXPECT_EQ(world.moves, moves);
  }
};

TEST_F(UncommandedMotion, PausesTheRunAndAcceptsNoPointOfIt) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  cell.until([&] { return cell.status().run->phase == "reading"; });
  push(0.01);
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  const auto accepted = cell.status().run->run.accepted;
  EXPECT_EQ(accepted, 3);
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.accepted, accepted) << "a person decides";
  EXPECT_THAT(alarms("motion.uncommanded"), SizeIs(1));
  EXPECT_THAT(cell.events_named("motion.uncommanded"), SizeIs(1));
  EXPECT_EQ(cell.await(cell.attempts(run.id))->back().verdict, Verdict::interrupted);
  EXPECT_THAT(cell.await(cell.attempts(run.id))->back().reason,
              HasSubstr("moved without a command"));

  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  const auto data = *cell.await(cell.datums(run.id));
  ASSERT_THAT(data, SizeIs(2));
  EXPECT_EQ(data[1].reason, "uncommanded motion");
  cell.pass(30);
  EXPECT_THAT(alarms("motion.uncommanded"), IsEmpty()) << "over with the new datum";
}

// An emergency stop that keeps the reference: only a person's order gives the drive its current.
TEST_F(UncommandedMotion, AServoThatWasSwitchedOffKeepsTheRunWaitingForAPerson) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  cell.until([&] { return cell.status().run->phase == "reading"; });
  const auto homes = world.homes, moves = world.moves;
  world.servo_on = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("servo was switched off"));
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.accepted, 3);
  EXPECT_FALSE(world.servo_on);
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(world.moves, moves);
  EXPECT_THAT(alarms("motion.servo_off"), SizeIs(1));
  EXPECT_THAT(alarms("motion.uncommanded"), IsEmpty()) << "nobody moved it";

  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_TRUE(world.servo_on) << "a person has resumed the run";
  const auto data = *cell.await(cell.datums(run.id));
  ASSERT_THAT(data, SizeIs(2));
  EXPECT_EQ(data[1].reason, "servo off");
  cell.pass(30);
  EXPECT_THAT(alarms("motion.servo_off"), IsEmpty());
}

// The same with a connection that breaks at that instant.
TEST_F(UncommandedMotion, AServoThatIsFoundOffAfterABreakKeepsTheRunWaitingForAPerson) {
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  world.axis_away = true;
  world.servo_on = false;
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  world.axis_away = false;
  expect_that_nobody_switches_it_on();
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

// A resume is about the machine as it stood then: what is switched off later stays off.
TEST_F(UncommandedMotion, AnEarlierResumeSwitchesNoServoOn) {
  const auto run = cell.begin_run(lines_of(4, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  pause_and_resume(run.id);
  cell.until([&] { return cell.status().run->run.accepted == 6; });
  world.axis_away = true;
  world.servo_on = false;
  until_waiting();
  world.axis_away = false;
  expect_that_nobody_switches_it_on();
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(UncommandedMotion, AStartSwitchesNoServoOnOnceItHasWaited) {
  world.laser_away = true;
  cell.begin_run(lines_of(1, {2, -3}, true));
  until_waiting();
  cell.pass(3600);
  world.servo_on = false;
  world.laser_away = false;
  expect_that_nobody_switches_it_on();
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

// Axes that have just got their power: a device that comes late is no reason to call somebody.
TEST_F(UncommandedMotion, AStartOfAxesThatWereNeverReferencedGoesOnByItselfAfterAWait) {
  world.servo_on = world.referenced = false;
  world.laser_away = true;
  cell.begin_run(lines_of(1, {2, -3}, true));
  until_waiting();
  cell.pass(3600);
  world.laser_away = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

// Another device is away: a resume whose look found that is none for what is switched off then.
TEST_F(UncommandedMotion, AResumeThatHasToWaitForADeviceSwitchesNoServoOn) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  static_cast<void>(cell.await(cell->manual.stop_all(cell.ada)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  world.laser_away = true;
  ASSERT_TRUE(cell.resume());
  cell.pass(3600);
  EXPECT_EQ(cell.status().run->run.accepted, 3);
  world.servo_on = false;
  world.laser_away = false;
  expect_that_nobody_switches_it_on();
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(cell.await(cell.datums(run.id))->back().reason, "servo off");
}

TEST_F(UncommandedMotion, AServoIsSeenToBeSwitchedOffWhileTheRunWaitsForAnotherDevice) {
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  world.laser_away = true;
  until_waiting();
  cell.pass(120);
  EXPECT_THAT(alarms("motion.servo_off"), IsEmpty());
  world.servo_on = false;
  cell.pass(30);
  EXPECT_THAT(alarms("motion.servo_off"), SizeIs(1));
  world.laser_away = false;
  expect_that_nobody_switches_it_on();
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(UncommandedMotion, IsNotWhatAControllerThatHaltsAtALimitSwitchIsAccusedOf) {
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 1; });
  world.limit_switch = true;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_THAT(cell.status().run->run.reason,
              testing::AllOf(HasSubstr("controller halted the axes"), HasSubstr("error 216")));
  EXPECT_THAT(cell.events_named("motion.halted"), SizeIs(1));
  EXPECT_THAT(cell.events_named("motion.uncommanded"), IsEmpty());
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(UncommandedMotion, IsSeenWithoutARunToo) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  cell.pass(20);
  EXPECT_THAT(alarms("motion.uncommanded"), IsEmpty());
  push(0.5);
  cell.pass(20);
  ASSERT_THAT(alarms("motion.uncommanded"), SizeIs(1));
  EXPECT_THAT(alarms("motion.uncommanded").front(), HasSubstr("q1"));
}

TEST_F(UncommandedMotion, IsSeenWhileARunIsPaused) {
  const auto run = cell.begin_run(lines_of(1, {2, -3}, true));
  cell.until([&] { return cell.status().run->run.accepted == 2; });
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run.id)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  cell.pass(20);
  push(0.5);
  cell.pass(20);
  EXPECT_THAT(alarms("motion.uncommanded"), SizeIs(1));
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(*cell.await(cell.datums(run.id)), SizeIs(2));
}

TEST_F(UncommandedMotion, IsNotSeenInARunThatNobodyDisturbs) {
  cell.begin_run(lines_of(3, {2, -3, 1}, true));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1.5})));
  cell.pass(60);
  EXPECT_THAT(cell.events_named("motion.uncommanded"), IsEmpty());
}

// A readback that is false is no motion: the interferometer says that the axis stands.
TEST(FalseReadback, IsToldFromMotionByTheMeasuredPose) {
  Folder folder;
  SmallWorld world;
  auto described = small_cell(folder / "cell.sqlite");
  auto& kinematics = described.kinematics.emplace();
  kinematics.kind = "linear-axis";
  kinematics.axes.push_back({{"q1", "mm"}, {"x", "mm"}, 0, 0});
  CellInMemory cell(world, described, kSqlite);
  const auto shift_readback = [&world](double by_mm) {
    world.from_mm = world.to_mm = world.to_mm + by_mm;
    world.move_end_ns = 0;
    world.zero_mm += by_mm;
  };
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  cell.until([&] { return cell.status().run->phase == "reading"; });
  shift_readback(0.1);
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  cell.pass(600);
  EXPECT_THAT(cell.events_named("motion.uncommanded"), IsEmpty());
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting) << "it is no matter for a person";
  shift_readback(-0.1);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(cell.events_named("motion.uncommanded"), IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
