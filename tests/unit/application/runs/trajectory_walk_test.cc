#include "server/application/runs/trajectory_walk.h"

#include <gtest/gtest.h>

#include <vector>

namespace driftwise::application {
namespace {

Trajectory lines(const std::vector<std::int64_t>& line_of_row,
                 const std::vector<std::int64_t>& zero_rows = {}) {
  Trajectory t;
  t.coordinates = {{"q1", "mm"}};
  for (const auto line : line_of_row)
    t.points.push_back({{1.0}, PointSet::calibration, line, false, {}, {}});
  for (const auto row : zero_rows) t.points[static_cast<std::size_t>(row)].zero = true;
  return t;
}

// Visits all rows; those in fails get `requeued` on their first visit. The order in which rows are
// visited.
std::vector<std::int64_t> walk(const Trajectory& trajectory, std::vector<std::int64_t> fails) {
  Place place;
  std::vector<std::int64_t> order;
  while (const auto visit = next_visit(trajectory, place)) {
    order.push_back(visit->row);
    const auto failing = std::find(fails.begin(), fails.end(), visit->row);
    const bool fail_now = failing != fails.end() && !visit->from_queue;
    place = place_after(place, *visit, fail_now ? Verdict::requeued : Verdict::accepted);
  }
  return order;
}

TEST(NextVisit, TakesTheRowsInOrder) {
  EXPECT_EQ(walk(lines({1, 1, 2}), {}), (std::vector<std::int64_t>{0, 1, 2}));
}

TEST(NextVisit, RepeatsQueuedRowsAtTheEndOfTheirLine) {
  EXPECT_EQ(walk(lines({1, 1, 1, 2, 2}), {0, 1}), (std::vector<std::int64_t>{0, 1, 2, 0, 1, 3, 4}));
}

TEST(NextVisit, RepeatsQueuedRowsOfTheLastLine) {
  EXPECT_EQ(walk(lines({1, 2, 2}), {1}), (std::vector<std::int64_t>{0, 1, 2, 1}));
}

TEST(NextVisit, EndsAnEmptyTrajectoryAtOnce) { EXPECT_FALSE(next_visit(lines({}), {})); }

TEST(PlaceAfter, CountsHowOftenARowWasQueued) {
  const auto trajectory = lines({1});
  auto place = place_after({}, *next_visit(trajectory, {}), Verdict::requeued);
  EXPECT_EQ(place, (Place{1, {{0, 1}}}));
  place = place_after(place, *next_visit(trajectory, place), Verdict::requeued);
  EXPECT_EQ(place, (Place{1, {{0, 2}}}));
  place = place_after(place, *next_visit(trajectory, place), Verdict::given_up);
  EXPECT_EQ(place, (Place{1, {}}));
  EXPECT_FALSE(next_visit(trajectory, place));
}

TEST(PlaceAfter, StaysWithAttemptsThatDecideNothing) {
  const Visit visit{3, 0, false};
  for (const auto verdict : {Verdict::reread, Verdict::reapproach, Verdict::interrupted})
    EXPECT_EQ(place_after({3, {}}, visit, verdict), (Place{3, {}}));
}

TEST(ReturnToZero, IsDueAfterALineWithoutOne) {
  const auto trajectory = lines({1, 1, 2, 2});
  EXPECT_FALSE(return_to_zero_is_due(trajectory, {1, {}}, 0));
  EXPECT_TRUE(return_to_zero_is_due(trajectory, {2, {}}, 1));
  EXPECT_TRUE(return_to_zero_is_due(trajectory, {4, {}}, 3));
}

TEST(ReturnToZero, IsNeverAddedWhereTheTrajectoryBringsIt) {
  const auto own = lines({1, 1, 2, 2}, {0, 3});
  EXPECT_FALSE(return_to_zero_is_due(own, {2, {}}, 1));
  EXPECT_FALSE(return_to_zero_is_due(own, {4, {}}, 3));
  const auto next_begins_there = lines({1, 1, 2, 2}, {2});
  EXPECT_FALSE(return_to_zero_is_due(next_begins_there, {2, {}}, 1));
}

TEST(ReturnToZero, WaitsForTheQueuedRowsOfTheLine) {
  const auto trajectory = lines({1, 1, 2});
  EXPECT_FALSE(return_to_zero_is_due(trajectory, {2, {{0, 1}}}, 1));
  EXPECT_TRUE(return_to_zero_is_due(trajectory, {2, {}}, 0));
}

TEST(ReturnToZero, IsOwedUntilTheAxesHaveReturned) {
  const auto trajectory = lines({1, 1, 2});
  SinceReturn since;
  since.begin({0, {}}, 0);
  EXPECT_FALSE(return_to_zero_is_owed(trajectory, {0, {}}, since)) << "nothing was measured";
  since.add(0, Verdict::accepted);
  EXPECT_FALSE(return_to_zero_is_owed(trajectory, {1, {}}, since)) << "the line is not over";
  since.add(1, Verdict::given_up);
  EXPECT_TRUE(return_to_zero_is_owed(trajectory, {2, {}}, since));
  since.returned = true;
  EXPECT_FALSE(return_to_zero_is_owed(trajectory, {2, {}}, since));
  since.add(2, Verdict::accepted);
  EXPECT_TRUE(return_to_zero_is_owed(trajectory, {3, {}}, since)) << "of the last line too";
}

TEST(RepeatSince, GoesBackToTheFirstRowOfTheStretch) {
  SinceReturn since;
  since.begin({3, {}}, 1);
  since.add(3, Verdict::accepted);
  since.add(4, Verdict::given_up);
  since.add(5, Verdict::requeued);
  since.add(5, Verdict::accepted);
  const auto line = repeat_since(since, {6, {}}, 2);
  EXPECT_EQ(line.place, (Place{3, {}}));
  EXPECT_EQ(line.rows, (std::vector<std::int64_t>{3, 5}));
  EXPECT_EQ(line.given_up, 1);
  EXPECT_EQ(since.accepted(), 2);
}

TEST(RepeatSince, QueuesRowsOfAnEarlierStretchAgain) {
  SinceReturn since;
  since.begin({3, {{1, 1}}}, 0);
  since.add(1, Verdict::accepted);  // came from the queue
  since.add(3, Verdict::accepted);
  const auto line = repeat_since(since, {4, {{0, 1}, {3, 1}}}, 0);
  EXPECT_EQ(line.place, (Place{3, {{0, 1}, {1, 1}}}));
  EXPECT_EQ(line.rows, (std::vector<std::int64_t>{1, 3}));
}

}  // namespace
}  // namespace driftwise::application
