#include "server/application/trajectories/pace.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

Trajectory plan_of(const std::vector<std::pair<std::int64_t, bool>>& lines_and_zeros) {
  Trajectory plan;
  for (const auto& [line, zero] : lines_and_zeros) {
    TrajectoryPoint point;
    point.line = line;
    point.zero = zero;
    plan.points.push_back(point);
  }
  return plan;
}

TEST(PlanLength, CountsDwellsReturnsToZeroAndRowsQueuedAgain) {
  // Line 1 returns by itself; line 2 has a zero of its own; line 3 is the last.
  Trajectory plan = plan_of({{1, false}, {1, false}, {2, false}, {2, true}, {3, false}});
  plan.points[1].dwell_s = 30;
  const PlanLength length(plan);
  EXPECT_DOUBLE_EQ(length.seconds({}, 10), (5 + 2) * 10 + 30);
  Place place;
  place.next_row = 4;
  place.requeued = {{1, 1}};
  EXPECT_DOUBLE_EQ(length.seconds(place, 10), (1 + 1 + 1) * 10 + 30);
  place = {};
  place.next_row = 5;
  EXPECT_DOUBLE_EQ(length.seconds(place, 10), 0);
}

TEST(PlanLength, NeedsNoReturnBeforeALineThatBeginsAtZero) {
  const PlanLength length(plan_of({{1, false}, {2, true}, {2, false}}));
  EXPECT_DOUBLE_EQ(length.seconds({}, 1), 3);
}

TEST(Pace, GuessesBeforeTheFirstPoint) { EXPECT_DOUBLE_EQ(Pace(14).point_s(), 14); }

TEST(Pace, FollowsTheLastPoints) {
  Pace pace(14);
  for (int i = 0; i < 1000; ++i) pace.add(i < 900 ? 100.0 : 10.0);
  EXPECT_DOUBLE_EQ(pace.point_s(), 10.0);
}

}  // namespace
}  // namespace driftwise::application
