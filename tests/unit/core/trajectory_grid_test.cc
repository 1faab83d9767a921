#include "server/core/trajectory/trajectory_grid.h"

#include <gtest/gtest.h>

#include <set>

namespace driftwise {
namespace {

Trajectory three_axes() {
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}, {"q2", "mm"}, {"q3", "mm"}};
  return plan;
}

PlanBlock grid(PointSet set, GridRange range, double force_n) {
  PlanBlock block;
  block.set = set;
  block.ranges = {range, range, range};
  block.force_n = force_n;
  return block;
}

// Section 6.2.2 of the study: 252 and 150 positions, 1056 in all, 756 of them for calibration.
TEST(AppendBlock, MakesThePublishedPlan) {
  auto plan = three_axes();
  const GridRange coarse{0, 2.5, 0.5}, between{0.25, 2.25, 0.5};
  ASSERT_TRUE(append_block(plan, grid(PointSet::calibration, coarse, 0)));
  EXPECT_EQ(plan.points.size(), 252u);
  ASSERT_TRUE(append_block(plan, grid(PointSet::calibration, coarse, 2.305)));
  ASSERT_TRUE(append_block(plan, grid(PointSet::validation, between, 0.768)));
  ASSERT_TRUE(append_block(plan, grid(PointSet::calibration, coarse, 1.536)));
  ASSERT_TRUE(append_block(plan, grid(PointSet::validation, between, 3.842)));
  ASSERT_EQ(plan.points.size(), 1056u);
  std::size_t calibration = 0, zeros = 0;
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    calibration += plan.points[i].set == PointSet::calibration;
    zeros += plan.points[i].zero;
    EXPECT_GE(plan.points[i].line, plan.points[i > 0 ? i - 1 : 0].line);
  }
  EXPECT_EQ(calibration, 756u);
  EXPECT_EQ(zeros, 3u * 36 + 2u * 25);
  EXPECT_EQ(plan.points.back().line, 3 * 36 + 2 * 25);
  EXPECT_TRUE(plan.points[6].zero) << "a line of six, then the return to zero";
  EXPECT_EQ(plan.points[1].target, (std::vector<double>{0, 0, 0.5}));
  EXPECT_EQ(plan.points[7].target, (std::vector<double>{0, 0.5, 0}));
  EXPECT_EQ(plan.points[42].target, (std::vector<double>{0.5, 0, 0}));
}

TEST(AppendBlock, GivesLevelsAsTheyAreWritten) {
  const GridRange tenths{0, 1, 0.1};
  EXPECT_EQ(tenths.levels(), 11);
  EXPECT_EQ(tenths.level_mm(3), 0.3);
}

TEST(AppendBlock, ScattersPositionsThatNoGridHas) {
  auto plan = three_axes();
  ASSERT_TRUE(append_block(plan, grid(PointSet::calibration, {0, 2.5, 0.1}, 0)));
  const auto before = plan.points.size();
  auto block = grid(PointSet::validation, {0.1, 2.4, 0}, 0.392);
  block.scattered = 94;
  block.seed = 7;
  ASSERT_TRUE(append_block(plan, block));
  ASSERT_EQ(plan.points.size(), before + 94);
  std::set<std::vector<double>> places;
  for (std::size_t i = before; i < plan.points.size(); ++i) {
    const auto& point = plan.points[i];
    EXPECT_FALSE(point.zero);
    EXPECT_EQ(point.force_n, 0.392);
    places.insert(point.target);
    for (const double mm : point.target) {
      EXPECT_GE(mm, 0.1);
      EXPECT_LE(mm, 2.4);
      EXPECT_GT(std::abs(mm * 10 - std::round(mm * 10)), 5e-4) << "on a level of the grid";
    }
  }
  EXPECT_EQ(places.size(), 94u);
  auto again = three_axes();
  ASSERT_TRUE(append_block(again, grid(PointSet::calibration, {0, 2.5, 0.1}, 0)));
  ASSERT_TRUE(append_block(again, block));
  EXPECT_EQ(again.points.back().target, plan.points.back().target) << "seeded";
}

TEST(AppendBlock, RefusesWhatIsNoPlan) {
  auto plan = three_axes();
  const auto reason = [&plan](const PlanBlock& block) {
    const auto done = append_block(plan, block);
    return done ? std::string() : done.error().reason;
  };
  EXPECT_EQ(reason(grid(PointSet::calibration, {0, 2.5, 0}, 0)), "BAD_PLAN");
  EXPECT_EQ(reason(grid(PointSet::calibration, {2.5, 0, 0.5}, 0)), "BAD_PLAN");
  EXPECT_EQ(reason(grid(PointSet::calibration, {0, 2.5, 1e-5}, 0)), "BAD_PLAN");
  // A count beyond every integer, alone and as a factor.
  EXPECT_EQ(reason(grid(PointSet::calibration, {0, 2.5, 1e-20}, 0)), "BAD_PLAN");
  EXPECT_EQ(reason(grid(PointSet::calibration, {0, 2.5, 1e-320}, 0)), "BAD_PLAN");
  auto one_tiny = grid(PointSet::calibration, {0, 1, 0.5}, 0);
  one_tiny.ranges.front() = {0, 5, 1e-20};
  EXPECT_EQ(reason(one_tiny), "BAD_PLAN");
  std::swap(one_tiny.ranges.front(), one_tiny.ranges.back());
  EXPECT_EQ(reason(one_tiny), "BAD_PLAN");
  auto two = grid(PointSet::calibration, {0, 2.5, 0.5}, 0);
  two.ranges.pop_back();
  EXPECT_EQ(reason(two), "BAD_PLAN");
  EXPECT_TRUE(plan.points.empty()) << "nothing is half-done";
}

}  // namespace
}  // namespace driftwise
