// What the axes may do, as far as this daemon knows.

#include "server/application/recording/motion_watch.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

MotionState at(double q_mm, bool moving = false, bool on_target = true) {
  return {CellTime{0}, {q_mm}, moving, true, on_target && !moving};
}

class MotionWatching : public testing::Test {
 protected:
  MotionWatch watch{{{"q1", "mm"}}, 1500};
};

TEST_F(MotionWatching, TakesWhereTheAxesRestFirstForGranted) {
  EXPECT_FALSE(watch.look(at(0.2, true)));
  EXPECT_FALSE(watch.look(at(0.4)));
  EXPECT_FALSE(watch.look(at(0.400035))) << "a loop that holds its place";
  const auto moved = watch.look(at(0.402));
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->kind, MotionFinding::Kind::moved);
  EXPECT_THAT(moved->sentence, testing::HasSubstr("q1 0.400000 mm, read back 0.402000 mm"));
  EXPECT_FALSE(watch.look(at(0.402))) << "told once";
}

TEST_F(MotionWatching, LetsACommandedMovePassAndSeesWhatFollows) {
  watch.look(at(0));
  watch.commanded({1});
  EXPECT_FALSE(watch.look(at(0.3, true)));
  EXPECT_FALSE(watch.look(at(0.9999, false, false))) << "not settled yet";
  EXPECT_FALSE(watch.look(at(0.9999995)));
  EXPECT_TRUE(watch.look(at(0.9, true))) << "away again, by itself";
}

TEST_F(MotionWatching, SeesAMoveThatWasReplacedByAnotherOne) {
  watch.commanded({1});
  EXPECT_FALSE(watch.look(at(0.3, true)));
  EXPECT_FALSE(watch.look(at(-0.5))) << "position and flag of one answer may be of two instants";
  const auto moved = watch.look(at(-0.5));
  ASSERT_TRUE(moved);
  EXPECT_THAT(moved->sentence, testing::HasSubstr("on target elsewhere: commanded q1 1.000000 mm"));
}

TEST_F(MotionWatching, SaysTheControllersOwnReasonForAMotionThatItEnded) {
  watch.commanded({1});
  auto halted = at(0.7);
  halted.halted_because = "error 1024 (motion error)";
  EXPECT_FALSE(watch.look(halted)) << "position and flag of one answer may be of two instants";
  const auto found = watch.look(halted);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, MotionFinding::Kind::halted);
  EXPECT_THAT(found->sentence, testing::AllOf(testing::HasSubstr("read back 0.700000 mm"),
                                              testing::HasSubstr("error 1024")));
  watch.commanded({1});
  halted.q_mm = {1};
  EXPECT_FALSE(watch.look(halted)) << "an error that ended nothing";
  EXPECT_FALSE(watch.look(halted));
}

TEST_F(MotionWatching, TellsAServoThatWasSwitchedOffFromAHandThatMovedTheAxis) {
  watch.look(at(1));
  auto off = at(0.4, false, false);
  off.servo_on = false;
  const auto found = watch.look(off);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, MotionFinding::Kind::servo_off);
  EXPECT_FALSE(watch.look(off)) << "told once";
  EXPECT_FALSE(watch.look(at(0.3))) << "on again: it rests where it has sunk to";
}

TEST_F(MotionWatching, ForgetsAMoveWhoseControllerWasLost) {
  watch.commanded({1});
  watch.look(at(0.3, true));
  watch.lost();
  EXPECT_FALSE(watch.look(at(0.4)));
  EXPECT_FALSE(watch.look(at(0.4))) << "its own watchdog may have ended the move";
  watch.lost();
  EXPECT_TRUE(watch.look(at(0.6))) << "at rest before, so somebody else moved it";
}

TEST_F(MotionWatching, ExpectsNothingAfterAStopAHomingOrALostReference) {
  watch.look(at(1));
  watch.released();
  EXPECT_FALSE(watch.look(at(0.2)));
  MotionState lost = at(7);
  lost.referenced = false;
  EXPECT_FALSE(watch.look(lost));
}

}  // namespace
}  // namespace driftwise::application
