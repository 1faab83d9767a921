#include <gtest/gtest.h>

#include <cmath>

#include "drivers/simulated/plant/cell/refractive_index.h"
#include "drivers/simulated/plant/file/plant_file.h"
#include "drivers/simulated/plant/linear_axis/measuring_loop.h"
#include "drivers/simulated/plant/linear_axis/parallelogram.h"
#include "drivers/simulated/plant/numbers/quintic.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::simulated {
namespace {

LinearAxisParameters shipped() {
  return std::get<LinearAxisParameters>(
      read_plant_file(testing_support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR), {}));
}

NodeTemperatures everywhere(double degc) {
  NodeTemperatures nodes;
  nodes.fill(degc);
  return nodes;
}

TEST(Parallelogram, DropsAsABarOfTheEffectiveLengthThatTurns) {
  ParallelogramParameters p{
      .left_length_mm = 60, .right_length_mm = 60, .shortening_factor = 0.6, .spacing_mm = 100};
  for (const double angle_deg : {-5.0, -1.0, 0.3, 4.8}) {
    const double angle = angle_deg * std::acos(-1.0) / 180;
    const double stage_mm = 50 * std::sin(angle);  // 60 / (2 x 0.6) = 50
    EXPECT_NEAR(stage_pose(p, stage_mm, 0, 0).rise_mm, -50 * (1 - std::cos(angle)), 1e-12);
  }
}

TEST(Parallelogram, ShortensByThreeFifthsOfTheSquareOverTheLengthForSmallMoves) {
  const ParallelogramParameters p{
      .left_length_mm = 60, .right_length_mm = 60, .shortening_factor = 0.6, .spacing_mm = 100};
  EXPECT_NEAR(stage_pose(p, 0.1, 0, 0).rise_mm, -0.6 * 0.01 / 60, 1e-9);
}

TEST(Parallelogram, TiltsTheBeamBackWhenTheRightLegIsWarmer) {
  ParallelogramParameters p = shipped().parallelogram;
  p.mirror_tilt_mrad = 0;
  // 8.6 ppm x 60 mm / 100 mm = 5.16 urad per kelvin, 45 mm above the scale: 232 nm.
  const double cold_mm = mirror_mm(p, 0, stage_pose(p, 0, 0, 0));
  const double warm_mm = mirror_mm(p, 0, stage_pose(p, 0, 0, 1));
  EXPECT_NEAR((warm_mm - cold_mm) * 1e6, -232.2, 0.2);
}

TEST(MeasuringLoop, MovesByTheHandSumForOneKelvinEverywhere) {
  const LinearAxisParameters plant = shipped();
  const LoopState cold = measuring_loop(plant, everywhere(20), 0);
  const LoopState warm = measuring_loop(plant, everywhere(21), 0);
  EXPECT_EQ(cold.robot_drift_nm, 0);
  EXPECT_EQ(cold.device_drift_nm, 0);
  // mm x ppm/K = nm: base, lower arm, upper arm, stage, cube; then the legs' rise on a mirror
  // tilted by 1 mrad.
  const double lengths_nm = 80 * 12 + 10 * 8.6 - 50 * 8.6 - 25 * 8.6 - 15 * 0.02;
  EXPECT_NEAR(warm.robot_drift_nm, lengths_nm + 60 * 8.6 * 1e-3, 0.1);
  // head, carrier, support and bridge.
  EXPECT_NEAR(warm.device_drift_nm, -25 * 12 + (-10 + 25 + 50) * 22.55, 1e-6);
}

TEST(MeasuringLoop, LeansWhenTheBaseIsWarmerOnTop) {
  const LinearAxisParameters plant = shipped();
  NodeTemperatures nodes = everywhere(20);
  // Antisymmetric about the mean, so that only the bend is left: 12e-6 x 0.002 K / 10 mm x 80 mm x
  // 130 mm.
  nodes[static_cast<std::size_t>(plant.bending.top)] += 0.001;
  nodes[static_cast<std::size_t>(plant.bending.bottom)] -= 0.001;
  EXPECT_NEAR(measuring_loop(plant, nodes, 0).robot_drift_nm, 12e-6 * 0.002 / 10 * 80 * 130 * 1e6,
              1e-6);
}

TEST(MeasuringLoop, ScaleErrorAndExpansionLengthenTheStage) {
  const LinearAxisParameters plant = shipped();
  const double stage_mm = stage_from_scale_mm(plant, everywhere(25), 4);
  EXPECT_NEAR(stage_mm, 4 * (1 - 3e-6 + 5 * 0.02e-6), 1e-9);
}

TEST(RefractiveIndex, ChangesAsTableA1OfTheStudySays) {
  const double here = refractivity(633, 20, 1013.25, 50);
  EXPECT_NEAR(here - refractivity(633, 20.3, 1013.25, 50), 2.8e-7, 0.1e-7);
  EXPECT_NEAR(refractivity(633, 20, 1013.75, 50) - here, 1.4e-7, 0.1e-7);
  EXPECT_NEAR(here - refractivity(633, 20, 1013.25, 53), 0.3e-7, 0.05e-7);
}

TEST(RefractiveIndex, IsThatOfStandardAir) {
  // Dry air, 20 degC, 1013.25 hPa, 633 nm: 271.8e-6 (any handbook of metrology).
  EXPECT_NEAR(refractivity(633, 20, 1013.25, 0), 271.8e-6, 0.1e-6);
}

TEST(Quintic, KeepsToVelocityAndAccelerationAndArrivesAtRest) {
  const double duration_s = quintic_duration_s(4, 5, 50);
  const Quintic profile(2, {.mm = 1}, 5, duration_s);
  for (double time_s = 2; time_s < 2 + duration_s; time_s += duration_s / 1000) {
    EXPECT_LE(std::abs(profile.at(time_s).mm_s), 5 * 1.0001);
    EXPECT_LE(std::abs(profile.at(time_s).mm_s2), 50 * 1.0001);
  }
  EXPECT_NEAR(profile.at(2).mm, 1, 1e-15);
  EXPECT_NEAR(profile.at(2 + duration_s / 2).mm, 3, 1e-12);
  EXPECT_EQ(profile.at(2 + duration_s).mm, 5);
  EXPECT_EQ(profile.at(2 + duration_s).mm_s, 0);
}

TEST(Quintic, TakesOverAMotionWithoutAJump) {
  const Quintic first(0, {}, 4, 2);
  const Kinematics taken = first.at(0.7);
  const Quintic second(0.7, taken, -1, 1.5);
  const Kinematics after = second.at(0.7 + 1e-9);
  EXPECT_NEAR(after.mm, taken.mm, 1e-7);
  EXPECT_NEAR(after.mm_s, taken.mm_s, 1e-6);
  EXPECT_NEAR(after.mm_s2, taken.mm_s2, 1e-5);
}

}  // namespace
}  // namespace driftwise::simulated
