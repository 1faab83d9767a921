#include "server/application/trajectories/trajectory_confounding.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "server/core/trajectory/trajectory_generator.h"
#include "server/core/trajectory/trajectory_grid.h"

namespace driftwise::application {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// The grids of the study's section 6.2.2 with the forces in a given order.
Trajectory plan_of(std::vector<std::pair<PointSet, double>> blocks) {
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}, {"q2", "mm"}, {"q3", "mm"}};
  for (const auto& [set, force_n] : blocks) {
    PlanBlock block;
    block.set = set;
    const GridRange range =
        set == PointSet::calibration ? GridRange{0, 2.5, 0.5} : GridRange{0.25, 2.25, 0.5};
    block.ranges = {range, range, range};
    block.force_n = force_n;
    EXPECT_TRUE(append_block(plan, block));
  }
  return plan;
}

std::vector<double> evenly(const Trajectory& plan) {
  std::vector<double> time_s;
  for (std::size_t i = 0; i < plan.points.size(); ++i)
    time_s.push_back(18.75 * static_cast<double>(i + 1));
  return time_s;
}

constexpr auto kCal = PointSet::calibration;
constexpr auto kVal = PointSet::validation;

TEST(ForceTrend, LetsThePublishedOrderPass) {
  const auto plan =
      plan_of({{kCal, 0}, {kCal, 2.305}, {kVal, 0.768}, {kCal, 1.536}, {kVal, 3.842}});
  const auto trend = force_trend(plan, evenly(plan));
  EXPECT_EQ(trend.rows, 756u);
  // By hand from the blocks' middles and lengths: 425.4 / sqrt(2.754 * 233484) = 0.53.
  EXPECT_NEAR(trend.correlation, 0.53, 0.01);
  EXPECT_FALSE(trend.confounded());
}

TEST(ForceTrend, ReportsARisingForceWithAnOrderThatIsBetter) {
  const auto plan =
      plan_of({{kCal, 0}, {kVal, 0.768}, {kCal, 1.536}, {kCal, 2.305}, {kVal, 3.842}});
  const auto trend = force_trend(plan, evenly(plan));
  EXPECT_GT(trend.correlation, 0.9);
  EXPECT_TRUE(trend.confounded());
  EXPECT_LT(std::abs(trend.better_correlation), 0.6);
  EXPECT_THAT(trend.better_n, testing::UnorderedElementsAre(0, 1.536, 2.305));
  EXPECT_THAT(trend.sentence(), HasSubstr("force_N rises along with time (correlation +0.9"));
  EXPECT_THAT(trend.sentence(), HasSubstr("Measure the forces in another order"));
}

TEST(ForceTrend, ReportsAFallingForceToo) {
  const auto plan = plan_of({{kCal, 2.305}, {kCal, 1.536}, {kCal, 0}});
  EXPECT_TRUE(force_trend(plan, evenly(plan)).confounded());
  EXPECT_THAT(force_trend(plan, evenly(plan)).sentence(), HasSubstr("falls"));
}

// What `trajectory generate --shuffle` makes, `trajectory check` must not refuse to believe in.
TEST(ForceTrend, IsNoneInARandomOrder) {
  for (const auto& forces : {std::vector<double>{0, 2}, {0, 1, 2}, {2.305, 1.536, 0}}) {
    for (const bool validation : {false, true}) {
      GeneratorPlan wanted;
      wanted.axes = {{{"q1", "mm"}, 0, 2, 5}, {{"q2", "mm"}, 0, 2, 3}};
      wanted.forces_n = forces;
      wanted.with_validation = validation;
      wanted.shuffle_seed = 1;
      const auto plan = generate_trajectory(wanted).value();
      const auto trend = force_trend(plan, evenly(plan));
      EXPECT_LT(std::abs(trend.correlation), 0.1);
      EXPECT_FALSE(trend.confounded());
      std::map<double, std::multiset<std::vector<double>>> under;  // every position, once a force
      for (const auto& point : plan.points)
        if (!point.zero) under[*point.force_n].insert(point.target);
      ASSERT_EQ(under.size(), forces.size());
      for (const auto& [force, positions] : under) EXPECT_EQ(positions, under.begin()->second);
      wanted.shuffle_seed.reset();
      const auto in_order = generate_trajectory(wanted).value();
      EXPECT_TRUE(force_trend(in_order, evenly(in_order)).confounded());
    }
  }
}

TEST(ForceTrend, HasNothingToSayWithoutForces) {
  auto plan = plan_of({{kCal, 0}});
  EXPECT_FALSE(force_trend(plan, evenly(plan)).confounded());
  for (auto& point : plan.points) point.force_n.reset();
  EXPECT_EQ(force_trend(plan, evenly(plan)).rows, 0u);
}

Trajectory grid_of(std::vector<GridRange> ranges) {
  Trajectory plan;
  for (std::size_t i = 0; i < ranges.size(); ++i)
    plan.coordinates.push_back({"q" + std::to_string(i + 1), "mm"});
  PlanBlock block;
  block.ranges = std::move(ranges);
  block.zeros = false;
  EXPECT_TRUE(append_block(plan, block));
  return plan;
}

TEST(LookAlikes, FindNoneOnThePublishedGrid) {
  EXPECT_THAT(look_alikes(plan_of({{kCal, 0}})), IsEmpty());
}

TEST(LookAlikes, NameTheTermsThatTwoLevelsCannotTellApart) {
  const auto found = look_alikes(grid_of({{0, 2, 2}, {0, 2.5, 0.1}}));
  ASSERT_THAT(found, testing::Not(IsEmpty()));
  EXPECT_EQ(found.front(),
            "q1^2 cannot be told apart from q1 on the calibration rows (q1 takes 2 values)");
}

TEST(LookAlikes, KnowThatACubicNeedsFourLevels) {
  const auto found = look_alikes(grid_of({{-1, 1, 1}, {-1, 1, 0.1}}));
  EXPECT_THAT(found, ElementsAre("q1^3 cannot be told apart from q1 on the calibration rows (q1 "
                                 "takes 3 values)"));
}

TEST(LookAlikes, SeeADiagonal) {
  auto plan = grid_of({{0, 3, 0.05}, {0, 0, 1}});
  for (auto& point : plan.points) point.target[1] = point.target[0];
  const auto found = look_alikes(plan);
  ASSERT_THAT(found, testing::Not(IsEmpty()));
  EXPECT_THAT(found.front(), HasSubstr("q2 cannot be told apart from q1"));
}

TEST(LookAlikes, LeaveACoordinateAloneThatNeverMoves) {
  const auto found = look_alikes(grid_of({{0, 3, 0.05}, {0, 0, 1}}));
  ASSERT_THAT(found, testing::Not(IsEmpty()));
  EXPECT_THAT(found.front(), HasSubstr("q2 is constant"));
}

}  // namespace
}  // namespace driftwise::application
