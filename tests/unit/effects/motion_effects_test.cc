// Play, creep and self-heating against other ways to work out the same mechanism: a brute-force
// walk in small steps, an integration of the differential equation, and facts of the mechanism.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "server/effects/effect.h"

namespace driftwise::effects {
namespace {

std::unique_ptr<EffectState> make_effect(const std::string& name, double value,
                                         const std::string& unit) {
  const std::vector<Quantity> parameters = {{value, unit}};
  return find_effect(name)->make(parameters);
}

double feed(EffectState& state, double time_s, std::vector<double> inputs) {
  return state.step(time_s, inputs);
}

TEST(Play, TakesUpItsWidthBeforeItFollows) {
  const auto play = make_effect("play", 80, "nm");
  EXPECT_EQ(feed(*play, 0, {1.0}), 0);                    // in the middle
  EXPECT_NEAR(feed(*play, 1, {1.00003}), -30e-6, 1e-15);  // still resting
  EXPECT_NEAR(feed(*play, 2, {1.5}), -40e-6, 1e-15);      // dragged behind
  EXPECT_NEAR(feed(*play, 3, {1.49995}), 10e-6, 1e-15);   // turned: resting again
  EXPECT_NEAR(feed(*play, 4, {0.0}), 40e-6, 1e-15);       // dragged the other way
}

TEST(Play, AgreesWithAContactThatIsPushedInSmallSteps) {
  // A block between two stops at +-w/2 of the drive, pushed along a path cut into 1 nm steps.
  const double half_width_mm = 42.5e-6;
  const auto play = make_effect("play", 85, "nm");
  std::mt19937 random(11);
  std::uniform_int_distribution<int> to_nm(-400, 400);
  int drive_nm = 0;
  double block_mm = 0;
  feed(*play, 0, {0.0});
  for (int k = 1; k <= 200; ++k) {
    const int goal_nm = to_nm(random);
    while (drive_nm != goal_nm) {
      drive_nm += goal_nm > drive_nm ? 1 : -1;
      const double gap = block_mm - drive_nm * 1e-6;
      if (gap > half_width_mm) block_mm = drive_nm * 1e-6 + half_width_mm;
      if (gap < -half_width_mm) block_mm = drive_nm * 1e-6 - half_width_mm;
    }
    EXPECT_NEAR(feed(*play, k, {goal_nm * 1e-6}), block_mm - goal_nm * 1e-6, 1e-15);
  }
}

TEST(Creep, OfOneMoveDiesAwayWithTau) {
  const auto creep = make_effect("creep", 300, "s");
  EXPECT_EQ(feed(*creep, 0, {0.0, 5.0}), 0);
  EXPECT_NEAR(feed(*creep, 100, {2.0, 30.0}), 2 * std::exp(-0.1), 1e-15);
  EXPECT_NEAR(feed(*creep, 400, {2.0, 330.0}), 2 * std::exp(-1.1), 1e-15);
}

TEST(Creep, IsTheSumOfWhatEveryMoveLeft) {
  const double tau = 120;
  const auto creep = make_effect("creep", tau, "s");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(-4, 4), dwell(1, 12);
  struct Move {
    double at, length;
  };
  std::vector<Move> moves;
  double q = 0, time = 0;
  feed(*creep, 0, {q, 1});
  for (int k = 0; k < 300; ++k) {
    time += 14.3;
    const double next = position(random), waited = dwell(random);
    moves.push_back({time - waited, next - q});
    q = next;
    double expected = 0;
    for (const auto& move : moves) expected += move.length * std::exp(-(time - move.at) / tau);
    EXPECT_NEAR(feed(*creep, time, {q, waited}), expected, 1e-12);
  }
}

TEST(SelfHeating, OfASteadySpeedSettlesToIt) {
  const auto heat = make_effect("heat", 600, "s");
  double last = 0;
  for (int k = 0; k <= 1000; ++k) last = feed(*heat, 10.0 * k, {k % 2 == 0 ? 0.0 : 3.0});
  EXPECT_NEAR(last, 0.3, 1e-6);
}

TEST(SelfHeating, CoolsWhileTheAxisRests) {
  const auto heat = make_effect("heat", 600, "s");
  feed(*heat, 0, {0.0});
  const double warm = feed(*heat, 60, {5.0});
  EXPECT_NEAR(feed(*heat, 660, {5.0}), warm * std::exp(-1.0), 1e-15);
}

TEST(SelfHeating, AgreesWithAnIntegrationInSmallSteps) {
  const double tau = 200;
  const auto heat = make_effect("heat", tau, "s");
  std::mt19937 random(9);
  std::uniform_real_distribution<double> position(-4, 4), interval(5, 40);
  double time = 0, q = 0, store = 0, last = 0;
  feed(*heat, 0, {0.0});
  for (int k = 0; k < 200; ++k) {
    const double dt = interval(random), next = position(random), speed = std::abs(next - q) / dt;
    const int steps = 20000;
    for (int i = 0; i < steps; ++i) store += dt / steps / tau * (speed - store);
    time += dt;
    q = next;
    last = feed(*heat, time, {q});
  }
  EXPECT_NEAR(last, store, 1e-5);
}

TEST(MotionEffects, PassOverAMissingValue) {
  for (const auto* name : {"play", "heat"}) {
    const auto state = make_effect(name, 100, std::string(name) == "play" ? "nm" : "s");
    const auto other = state->clone();
    feed(*state, 0, {0.0});
    feed(*other, 0, {0.0});
    EXPECT_TRUE(std::isnan(feed(*state, 5, {std::numeric_limits<double>::quiet_NaN()}))) << name;
    EXPECT_EQ(feed(*state, 10, {1.0}), feed(*other, 10, {1.0})) << name;
  }
}

}  // namespace
}  // namespace driftwise::effects
