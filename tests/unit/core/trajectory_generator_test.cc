#include "server/core/trajectory/trajectory_generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace driftwise {
namespace {

GeneratorPlan plane(std::int64_t x = 4, std::int64_t y = 3) {
  GeneratorPlan plan;
  plan.axes = {{{"q1", "mm"}, 0, 3, x}, {{"q2", "mm"}, 0, 1, y}};
  return plan;
}

std::vector<TrajectoryPoint> without_zeros(const Trajectory& trajectory, PointSet set) {
  std::vector<TrajectoryPoint> out;
  for (const auto& point : trajectory.points)
    if (!point.zero && point.set == set) out.push_back(point);
  return out;
}

TEST(GeneratedTrajectory, VisitsEveryNodeOnceAndReturnsToZeroAfterEachLine) {
  const auto trajectory = generate_trajectory(plane()).value();
  ASSERT_EQ(trajectory.points.size(), 4U * 3 + 3);
  std::set<std::vector<double>> nodes;
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    EXPECT_EQ(trajectory.points[i].zero, i % 5 == 4);
    EXPECT_EQ(trajectory.points[i].line, static_cast<std::int64_t>(i / 5));
    if (!trajectory.points[i].zero) nodes.insert(trajectory.points[i].target);
  }
  EXPECT_EQ(nodes.size(), 12U);
  EXPECT_TRUE(nodes.contains({3, 1}));
  EXPECT_TRUE(nodes.contains({1, 0.5}));
}

TEST(GeneratedTrajectory, ValidatesInTheMiddlesOfTheCells) {
  auto plan = plane();
  plan.with_validation = true;
  const auto trajectory = generate_trajectory(plan).value();
  const auto middles = without_zeros(trajectory, PointSet::validation);
  ASSERT_EQ(middles.size(), 3U * 2);
  EXPECT_EQ(middles.front().target, (std::vector<double>{0.5, 0.25}));
  EXPECT_EQ(without_zeros(trajectory, PointSet::calibration).size(), 12U);
  // Interleaved: some validation comes before the last calibration point.
  const auto first = std::find_if(trajectory.points.begin(), trajectory.points.end(),
                                  [](const auto& p) { return p.set == PointSet::validation; });
  EXPECT_LT(first - trajectory.points.begin(), 8);
}

TEST(GeneratedTrajectory, RepeatsTheWholeGridUnderEachForceAndBackwards) {
  auto plan = plane(2, 1);
  plan.forces_n = {0, 2.5};
  plan.repeats = 2;
  plan.both_directions = true;
  const auto trajectory = generate_trajectory(plan).value();
  const auto points = without_zeros(trajectory, PointSet::calibration);
  ASSERT_EQ(points.size(), 8U);
  EXPECT_EQ(points[0].target[0], 0);
  EXPECT_EQ(points[2].target[0], 3);  // backwards
  EXPECT_EQ(points[3].force_n, 0);
  EXPECT_EQ(points[4].force_n, 2.5);
  EXPECT_EQ(trajectory.points.back().line, 3);
}

TEST(GeneratedTrajectory, ASeedGivesTheSameOrderEachTime) {
  auto plan = plane(10, 10);
  plan.shuffle_seed = 5;
  const auto once = generate_trajectory(plan).value(), again = generate_trajectory(plan).value();
  plan.shuffle_seed = 6;
  const auto other = generate_trajectory(plan).value();
  const auto order = [](const Trajectory& trajectory) {
    std::vector<std::vector<double>> out;
    for (const auto& point : without_zeros(trajectory, PointSet::calibration))
      out.push_back(point.target);
    return out;
  };
  EXPECT_EQ(order(once), order(again));
  EXPECT_NE(order(once), order(other));
  auto sorted = order(once), plain = order(generate_trajectory(plane(10, 10)).value());
  std::sort(sorted.begin(), sorted.end());
  std::sort(plain.begin(), plain.end());
  EXPECT_EQ(sorted, plain);
}

TEST(GeneratedTrajectory, NamesTheAxesOfOneOfSeveralRobots) {
  auto plan = plane();
  plan.axes[0].coordinate = {"ma.q1", "mm"};
  plan.axes[1].coordinate = {"mb.q1", "mm"};
  const auto trajectory = generate_trajectory(plan);
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->coordinates[0].name(), "ma.q1_mm");
  EXPECT_EQ(trajectory->points.size(), 4U * 3 + 3);
  plan.axes[0].coordinate = {"ma.force", "mm"};
  const auto refused = generate_trajectory(plan);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("ma.q1_mm"), std::string::npos);
}

TEST(GeneratedTrajectory, RefusesWhatMakesNoSense) {
  const auto reason = [](const GeneratorPlan& plan) {
    const auto made = generate_trajectory(plan);
    return made ? "" : made.error().reason;
  };
  EXPECT_EQ(reason({}), "BAD_PLAN");
  auto twice = plane();
  twice.axes[1].coordinate = twice.axes[0].coordinate;
  EXPECT_EQ(reason(twice), "BAD_PLAN");
  auto backwards = plane();
  backwards.axes[0].to_mm = -1;
  EXPECT_EQ(reason(backwards), "BAD_PLAN");
  auto none = plane(0, 3);
  EXPECT_EQ(reason(none), "BAD_PLAN");
  EXPECT_EQ(reason(plane(10'000, 10'000)), "TOO_MANY_ROWS");
  auto zeros = plane(400, 300);
  zeros.line_length = 1;
  EXPECT_EQ(reason(zeros), "TOO_MANY_ROWS");  // because of the returns to zero
}

}  // namespace
}  // namespace driftwise
