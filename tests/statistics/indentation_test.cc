// The fast part of indentation_count: decisions of server/indentation on the two robots' plant.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/statistics/touching_robots.h"

namespace driftwise::statistics {
namespace {

TEST(Indentation, AlignsASubstrateTiltedByRandomInAtMostThreeCorrections) {
  TouchingRobots robots(3);
  const auto aligned = align(robots);
  EXPECT_TRUE(aligned.accepted) << aligned.trouble;
  EXPECT_LE(aligned.record.corrections, 3);
  EXPECT_LE(aligned.record.spread_nm, 500);
  // At the truth, not at the contacts: 500 nm, a step at each contact, the holding error.
  EXPECT_LT(aligned.left_nm, 800);
}

TEST(Indentation, SeesNoContactInTwentyApproachesWithKnocksAndDrift) {
  const auto count = count_false_contacts(5, 20);
  EXPECT_EQ(count.contacts, 0);
  EXPECT_EQ(count.aborts, 0);
}

TEST(Indentation, TellsAContactWithinOneStepOfTheMoveThatTouches) {
  const auto count = count_contacts(6, 20);
  EXPECT_EQ(count.contacts, 20);
  EXPECT_EQ(count.before, 0);
  EXPECT_EQ(count.moves[2] + count.moves[3] + count.later, 0);
}

// A place that is higher than the file's depart_mm: the surface is where the gap at the truth ends.
TEST(Indentation, TakesNoHeightWhereTheToolIsInTheWorkPieceAlready) {
  using Kind = indentation::Approach::Next::Kind;
  for (const double beyond_um : {0.1, 2.0, 10.0}) {
    TouchingRobots robots(3);
    const auto now = [&robots] { return std::llround(robots.time_s() * 1e9); };
    robots.plant().set_substrate_arcsec(0, 0, now());
    (void)robots.move_below(0, 0, 1.5);
    const double surface_mm = 1.5 + robots.plant().contact(now()).gap_nm * 1e-6;
    (void)robots.move_below(0, 0, 1);
    robots.pass(30);
    const double depart_mm = surface_mm + beyond_um * 1e-3;
    const auto end = robots.approach({.depart_mm = depart_mm, .highest_mm = depart_mm + 0.09}, {});
    EXPECT_EQ(end.kind, beyond_um < 5 ? Kind::touching : Kind::abort) << beyond_um;
    EXPECT_EQ(end.height_mm, depart_mm) << "not a step further";
  }
}

TEST(Indentation, LeavesACraterThatGrowsWithThePress) {
  TouchingRobots robots(4);
  (void)robots.move_above(0, 0, 1);
  const auto touched = robots.approach({.depart_mm = 1.555, .highest_mm = 1.645}, {});
  ASSERT_EQ(touched.kind, indentation::Approach::Next::Kind::contact) << touched.why;
  robots.pass(30);
  ASSERT_EQ(robots.plant().craters().size(), 1U);
  const auto first = robots.plant().craters().front();
  // A contact is found at the step that touches, hence five steps and not four.
  (void)robots.move_below(0, 0, touched.height_mm + 0.00125);
  robots.pass(30);
  const auto pressed = robots.plant().craters().front();
  EXPECT_GT(pressed.depth_nm, first.depth_nm + 500);
  // 5 to 10 um of diagonal are 22 to 90 mN by the study's formula.
  const double d_um = simulated::diagonal_um(pressed);
  EXPECT_GT(d_um, 5);
  EXPECT_LT(d_um, 12);
  // Without contact the robot comes back to where it holds, and the crater keeps its depth.
  // Held by friction, the robot below wanders by some nm before it leaves.
  (void)robots.move_below(0, 0, 1.5);
  const auto left = robots.plant().craters().front();
  EXPECT_NEAR(left.depth_nm, pressed.depth_nm, 50);
  robots.pass(120);
  EXPECT_NEAR(robots.plant().contact(0).push_nm, 0, 40);
  EXPECT_EQ(robots.plant().craters().front().depth_nm, left.depth_nm);
}

}  // namespace
}  // namespace driftwise::statistics
