#include "server/application/motion/keep_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace driftwise::application {
namespace {

// Two robots of two axes each; the distance has another share of each axis.
CellDescription opposed_robots() {
  CellDescription cell;
  KeepOutDescription rule{"tips", 1, 3, {}, {"ma", "mn"}};
  const double per_mm[] = {-1, 0.25, -0.5, 0.75};
  for (int i = 0; i < 4; ++i) {
    const Channel channel{(i < 2 ? "ma.q" : "mn.q") + std::to_string(i % 2 + 1), "mm"};
    cell.devices.emplace_back().become<MotionSettings>().axes.push_back({channel, "X", -9, 9, 0});
    rule.terms.push_back({channel, per_mm[i]});
  }
  cell.robots = {{"ma", "", {}, "", {}}, {"mn", "", {}, "", {}}};
  cell.keep_outs = {rule};
  return cell;
}

double distance_mm(const KeepOutDescription& rule, const std::vector<double>& q_mm) {
  double distance = rule.at_zero_mm;
  for (std::size_t i = 0; i < q_mm.size(); ++i) distance += rule.terms[i].per_mm * q_mm[i];
  return distance;
}

// The axes arrive one after the other in any order, and stop at any place between: what the check
// allows never comes too near, and what it refuses does so somewhere.
TEST(KeepOut, IsJudgedAtTheWorstPlaceBetweenTheEnds) {
  const auto cell = opposed_robots();
  const auto& rule = cell.keep_outs.front();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-2, 2), share(0, 1);
  int allowed = 0, refused = 0;
  for (int n = 0; n < 2000; ++n) {
    std::vector<double> from(4), to(4);
    for (auto* end : {&from, &to})
      for (double& q : *end) q = place(random);
    if (distance_mm(rule, from) < rule.min_mm) continue;
    const bool may = check_keep_out(cell, from, to).has_value();
    (may ? allowed : refused)++;
    double nearest = std::min(distance_mm(rule, from), distance_mm(rule, to));
    for (unsigned arrived = 0; arrived < 16; ++arrived) {
      auto corner = from, between = from;
      for (std::size_t i = 0; i < 4; ++i) {
        if (arrived & (1u << i)) corner[i] = to[i];
        between[i] += share(random) * (to[i] - from[i]);
      }
      nearest = std::min({nearest, distance_mm(rule, corner), distance_mm(rule, between)});
    }
    EXPECT_EQ(may, nearest >= rule.min_mm) << n;
  }
  EXPECT_GT(allowed, 100);
  EXPECT_GT(refused, 100);
}

TEST(KeepOut, FromAPlaceThatIsTooNearOnlyTheWayOutIsAllowed) {
  const auto cell = opposed_robots();
  const std::vector<double> near{3, 0, 0, 0};  // 0 mm
  EXPECT_TRUE(check_keep_out(cell, near, {2.5, 0, 0, 0}))
      << "still too near, and farther than before";
  EXPECT_TRUE(check_keep_out(cell, near, near));
  EXPECT_FALSE(check_keep_out(cell, near, {3.1, 0, 0, 0}));
  EXPECT_FALSE(check_keep_out(cell, near, {0, 0, 1, 0})) << "on the way both are nearer";
}

TEST(KeepOut, IsAskedOfEachControllerThatIsHomed) {
  const auto cell = opposed_robots();  // four controllers: ma.q1, ma.q2, mn.q1, mn.q2
  EXPECT_TRUE(check_homing(cell, {2, 0, 0, 0})) << "1 mm here, 3 mm at the zeros";
  EXPECT_TRUE(check_homing(cell, {-2, 0, 4, 0})) << "3 mm here, 1 mm once ma is at its zero";
  // 3 mm here; with ma at its zero mn would be at 0 mm.
  const auto refused = check_homing(cell, {-3, 0, 6, 0});
  ASSERT_TRUE(check_homing(cell, {-3, 0, 3.9, 0}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "KEEP_OUT");
}

TEST(KeepOut, NamesTheRobotThatMakesRoom) {
  const auto cell = opposed_robots();
  // ma retires by 2 mm, mn follows by 4: in this order only.
  const std::vector<double> from{2, 0, 0, 0}, to{0, 0, 4, 0};
  EXPECT_FALSE(check_keep_out(cell, from, to));
  EXPECT_EQ(first_to_move(cell, from, to), "ma");
  EXPECT_EQ(first_to_move(cell, to, from), "mn");
  EXPECT_EQ(first_to_move(cell, {0, 0, 0, 0}, {2, 0, 4, 0}), std::nullopt);
}

TEST(KeepOut, IsNothingWithoutRules) {
  auto cell = opposed_robots();
  cell.keep_outs.clear();
  EXPECT_TRUE(check_keep_out(cell, {9, 9, 9, 9}, {-9, -9, 9, 9}));
}

}  // namespace
}  // namespace driftwise::application
