#include "server/plausibility/geometry_judge.h"

#include <gtest/gtest.h>

#include "tests/unit/plausibility/cells.h"

namespace driftwise::plausibility {
namespace {

// geometry_um 20 and 1 % of the way are the defaults.
bool disagrees(const CellDescription& cell, double x_mm, double q_mm) {
  return GeometryJudge(cell)
      .compare({{"x_mm", x_mm}}, {{"q1_mm", q_mm}}, {{"q1_mm", 0.001}})
      .disagrees();
}

TEST(GeometryJudge, ALengthThatFollowsTheAxisAgrees) {
  EXPECT_FALSE(disagrees(cell(), 0.0, 0.001));
  EXPECT_FALSE(disagrees(cell(), 2.0, 2.001));
  EXPECT_FALSE(disagrees(cell(), 2.039, 2.001)) << "a changed robot is no lying instrument";
}

TEST(GeometryJudge, ALengthThatDoesNotFollowDisagrees) {
  EXPECT_TRUE(disagrees(cell(), 0.0, 2.001)) << "constant";
  EXPECT_TRUE(disagrees(cell(), -2.0, 2.001)) << "inverted";
  EXPECT_TRUE(disagrees(cell(), 2000.0, 2.001)) << "micrometres";
  EXPECT_TRUE(disagrees(cell(), 2.041, 2.001)) << "beyond 20 um and 1 % of 2 mm";
  EXPECT_TRUE(disagrees(cell(), 1e308, 2.001));
}

TEST(GeometryJudge, TheSentenceNamesTheMotorAndTheLimit) {
  const auto found =
      GeometryJudge(cell()).compare({{"x_mm", -2.0}}, {{"q1_mm", 2}}, {{"q1_mm", 0}});
  EXPECT_NE(found.sentence().find("q1_mm by the measured pose is -4 mm"), std::string::npos)
      << found.sentence();
}

TEST(GeometryJudge, EachRobotIsHeldAgainstItsOwnReadback) {
  auto two = cell();
  two.robots = {{"ma", "", {}, "", two.kinematics}, {"mn", "", {}, "", two.kinematics}};
  const auto found = GeometryJudge(two).compare({{"ma.x_mm", 2.0}, {"mn.x_mm", 2.0}},
                                                {{"ma.q1_mm", 2.0}, {"mn.q1_mm", -1.0}},
                                                {{"ma.q1_mm", 0.0}, {"mn.q1_mm", 0.0}});
  ASSERT_EQ(found.outputs.size(), 2u);
  EXPECT_TRUE(found.disagrees());
  EXPECT_NE(found.sentence().find("mn.q1_mm by the measured pose is +3 mm"), std::string::npos)
      << found.sentence();
  EXPECT_EQ(found.sentence().find("ma.q1_mm"), std::string::npos);
}

TEST(GeometryJudge, NothingIsComparedWithoutADeclaredGeometry) {
  auto unknown = cell();
  unknown.kinematics.reset();
  EXPECT_FALSE(GeometryJudge(unknown).knows());
  EXPECT_FALSE(disagrees(unknown, -2.0, 2.001));
}

TEST(GeometryJudge, AMissingLengthIsNotCompared) {
  EXPECT_FALSE(GeometryJudge(cell()).compare({}, {{"q1_mm", 2}}, {{"q1_mm", 0}}).disagrees());
}

}  // namespace
}  // namespace driftwise::plausibility
