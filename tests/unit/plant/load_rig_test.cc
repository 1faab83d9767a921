#include "drivers/simulated/plant/micro_nano/load_rig.h"

#include <gtest/gtest.h>

namespace driftwise::simulated {
namespace {

LoadParameters rig_parameters() {
  return {.max_n = 3.85,
          .weight_n = 0.192,
          .seconds_per_weight = 2,
          .swing_share = 0.02,
          .swing_s = 3,
          .swing_period_s = 1.2,
          .rest_s = 20,
          .g_declared_m_s2 = 9.81,
          .g_here_m_s2 = 9.806,
          .pan_n = 0.1,
          .friction = 0.015,
          .wire_n_mm = 38,
          .attach_mm = {},
          .pulley_height_mm = 380};
}

constexpr double kFull_n = 3.84 * 9.806 / 9.81 + 0.1;  // what really hangs
constexpr double kWire_mm = 380;

LoadRig loaded() {
  LoadRig rig(rig_parameters(), kWire_mm);
  rig.set_newton(3.84, 0);
  rig.settle(1000, kWire_mm);
  return rig;
}

TEST(LoadRig, LaysItsWeightsOnOneByOneAndThenComesToRest) {
  LoadRig rig(rig_parameters(), kWire_mm);
  rig.set_newton(3.84, 0);  // twenty weights: 40 s, then 20 s of rest
  EXPECT_NEAR(rig.state(20).newton, 1.92, 1e-9);
  EXPECT_FALSE(rig.state(59).resting);
  EXPECT_TRUE(rig.state(60.1).resting);
  EXPECT_EQ(rig.state(60.1).newton, 3.84);
  EXPECT_NE(rig.tension_n(40.3, kWire_mm), rig.tension_n(100, kWire_mm)) << "it swings";
}

TEST(LoadRig, LessArrivesThanHangsAfterLoadingAndMoreAfterUnloading) {
  EXPECT_NEAR(loaded().tension_n(1000, kWire_mm), kFull_n * (1 - 0.015), 1e-9);
  LoadRig rig = loaded();
  rig.set_newton(1.92, 1000);
  EXPECT_NEAR(rig.tension_n(2000, kWire_mm), (1.92 * 9.806 / 9.81 + 0.1) * (1 + 0.015), 1e-9);
}

TEST(LoadRig, FrictionDependsOnTheDirectionOfTheLastMove) {
  LoadRig rig = loaded();
  // Down by a millimetre: the wire is drawn, the pulleys hold back.
  const double down_n = rig.tension_n(1010, kWire_mm + 1);
  EXPECT_NEAR(down_n, kFull_n * (1 + 0.015), 1e-9);
  rig.settle(1010, kWire_mm + 1);
  // Back: at first the wire only relaxes, 38 N/mm, then it slips.
  EXPECT_NEAR(rig.tension_n(1011, kWire_mm + 0.999), down_n - 0.038, 1e-9);
  EXPECT_NEAR(rig.tension_n(1012, kWire_mm), kFull_n * (1 - 0.015), 1e-9);
}

TEST(LoadRig, StaysWhereItJams) {
  LoadRig rig(rig_parameters(), kWire_mm);
  rig.set_newton(1.92, 0);
  rig.set_jammed(true, 10);  // half way
  EXPECT_NEAR(rig.state(500).newton, 0.96, 1e-9);
  EXPECT_TRUE(rig.state(500).jammed);
  EXPECT_FALSE(rig.state(500).resting);
  rig.set_newton(3, 500);
  EXPECT_NEAR(rig.state(1000).newton, 0.96, 1e-9);
  rig.set_jammed(false, 1000);
  EXPECT_TRUE(rig.state(1100).resting);
  rig.set_newton(0, 1100);
  EXPECT_EQ(rig.state(2000).newton, 0);
}

}  // namespace
}  // namespace driftwise::simulated
