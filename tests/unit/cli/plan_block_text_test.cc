#include "clients/cli/commands/trajectories/plan_block_text.h"

#include <gtest/gtest.h>

namespace driftwise::cli {
namespace {

const std::vector<Channel> kAxes = {{"q1", "mm"}, {"q2", "mm"}};

TEST(PlanBlockText, GivesOneRangeToAllCoordinatesOrEachItsOwn) {
  const auto all = plan_block_from("calibration 0:2.5:0.5 force=2.305 dwell=15", kAxes);
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->set, PointSet::calibration);
  EXPECT_EQ(all->ranges[1].to_mm, 2.5);
  EXPECT_EQ(all->ranges[1].step_mm, 0.5);
  EXPECT_EQ(all->force_n, 2.305);
  EXPECT_EQ(all->dwell_s, 15);
  EXPECT_TRUE(all->zeros);
  const auto each = plan_block_from("validation q1=0:1:0.1 q2=-1:1:1 zeros=no", kAxes);
  ASSERT_TRUE(each) << each.error().message;
  EXPECT_EQ(each->ranges[0].step_mm, 0.1);
  EXPECT_EQ(each->ranges[1].from_mm, -1);
  EXPECT_FALSE(each->zeros);
  const auto scattered = plan_block_from("validation 0.1:2.4 scattered=94 seed=7", kAxes);
  ASSERT_TRUE(scattered) << scattered.error().message;
  EXPECT_EQ(scattered->scattered, 94);
  EXPECT_EQ(scattered->seed, 7u);
}

TEST(PlanBlockText, NamesTheAxesOfOneOfSeveralRobots) {
  const auto axes = coordinates_from("ma.q1,ma.q2");
  ASSERT_TRUE(axes) << axes.error().message;
  const auto block = plan_block_from("calibration ma.q1=0:2.5:0.5 ma.q2=0:1:0.5", *axes);
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_EQ(block->ranges[0].to_mm, 2.5);
  EXPECT_EQ(block->ranges[1].to_mm, 1);
  EXPECT_FALSE(plan_block_from("calibration q1=0:2.5:0.5 ma.q2=0:1:0.5", *axes))
      << "without the robot's id it is no axis of this plan";
}

TEST(PlanBlockText, NamesTheWordThatItDoesNotUnderstand) {
  for (const char* bad :
       {"", "calibration", "calibraton 0:1:1", "0:1:x", "0-1", "q1=0:1:1", "0:1:1 force=heavy",
        "0:1:1 force=nan", "0:inf:1", "0:1:1 dwell=inf", "0:1:1 zeros=maybe", "0:1 scattered=0",
        "0:1:1 q7=0:1:1", "0:1:1 scattered=1.5"}) {
    const auto block = plan_block_from(bad, kAxes);
    ASSERT_FALSE(block) << bad;
    EXPECT_EQ(block.error().reason, "BAD_BLOCK") << bad;
    EXPECT_NE(block.error().message.find("expected"), std::string::npos) << bad;
  }
}

TEST(PlanBlockText, ReadsCoordinates) {
  const auto axes = coordinates_from("x,y,z");
  ASSERT_TRUE(axes);
  EXPECT_EQ((*axes)[2].name(), "z_mm");
  const auto of_one_robot = coordinates_from("ma.q1,ma.q2");
  ASSERT_TRUE(of_one_robot) << of_one_robot.error().message;
  EXPECT_EQ((*of_one_robot)[1].name(), "ma.q2_mm");
  EXPECT_FALSE(coordinates_from("ma.,q1"));
  EXPECT_FALSE(coordinates_from(""));
  EXPECT_FALSE(coordinates_from("1"));
}

}  // namespace
}  // namespace driftwise::cli
