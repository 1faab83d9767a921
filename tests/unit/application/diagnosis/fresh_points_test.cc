#include "server/application/improvement/fresh_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "server/formats/csv/trajectory_csv.h"
#include "tests/support/cell_in_memory.h"

namespace driftwise::application {
namespace {

Trajectory three_lines() {
  const auto text = tests::lines_of(3, {-4, -2, 1, 4}, true);
  return *formats::read_trajectory_csv(text, "lines.csv");
}

TEST(FreshPoints, AreNoneThatWereVisitedInNoneOfTwentyRepeats) {
  const auto plan = three_lines();
  std::set<double> seen;
  for (const auto& point : plan.points) seen.insert(point.target[0]);
  for (int repeat = 1; repeat <= 20; ++repeat) {
    const auto fresh = fresh_points(plan, repeat);
    std::set<double> here;
    for (const auto& point : fresh.points)
      if (!point.zero) here.insert(point.target[0]);
    EXPECT_EQ(here.size(), 4u) << repeat;
    for (const double q : here) EXPECT_TRUE(seen.insert(q).second) << repeat << ": " << q;
  }
}

// A return to zero after each position: each is a line of its own.
TEST(FreshPoints, AreNewWhereALineHasOnePosition) {
  auto plan = *formats::read_trajectory_csv(tests::lines_of(1, {-4, -2, 1, 4}, false), "ones.csv");
  std::vector<TrajectoryPoint> points;
  for (auto point : plan.points) {
    point.line = static_cast<std::int64_t>(points.size());
    points.push_back(point);
    point.target = {0};
    point.zero = true;
    points.push_back(point);
  }
  plan.points = std::move(points);
  std::set<double> seen{-4, -2, 1, 4};
  for (int repeat = 1; repeat <= 20; ++repeat)
    for (const auto& point : fresh_points(plan, repeat).points) {
      if (point.zero) {
        EXPECT_EQ(point.target[0], 0);
        continue;
      }
      EXPECT_TRUE(seen.insert(point.target[0]).second) << repeat << ": " << point.target[0];
      EXPECT_GE(point.target[0], -4);
      EXPECT_LE(point.target[0], 4);
    }
}

TEST(FreshPoints, StayInsideTheHullInOrderWithTheirSetsAndZeros) {
  const auto plan = three_lines();
  const auto fresh = fresh_points(plan, 3);
  ASSERT_EQ(fresh.points.size(), plan.points.size());
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    EXPECT_EQ(fresh.points[i].zero, plan.points[i].zero);
    EXPECT_EQ(fresh.points[i].set, plan.points[i].set);
    if (plan.points[i].zero) {
      EXPECT_EQ(fresh.points[i].target[0], 0);
    }
    EXPECT_GE(fresh.points[i].target[0], -4);
    EXPECT_LE(fresh.points[i].target[0], 4);
    if (i > 0 && !fresh.points[i].zero && !fresh.points[i - 1].zero) {
      EXPECT_GT(fresh.points[i].target[0], fresh.points[i - 1].target[0]) << i;
    }
  }
  EXPECT_EQ(fresh_points(plan, 0).points[1].target, plan.points[1].target);
}

}  // namespace
}  // namespace driftwise::application
