#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

TEST(PlantAxis, KnowsNoReferenceUntilItHasSearchedForIt) {
  const auto plant = warm_plant();
  EXPECT_FALSE(plant->axis(0, at(0)).referenced);
  plant->start_reference(0, at(1));
  const AxisState searching = plant->axis(0, at(3));
  EXPECT_TRUE(searching.referencing);
  EXPECT_TRUE(searching.moving);
  EXPECT_FALSE(searching.referenced);
  const AxisState found = plant->axis(0, at(12));
  EXPECT_TRUE(found.referenced);
  EXPECT_TRUE(found.on_target);
  EXPECT_FALSE(found.moving);
  EXPECT_NEAR(found.q_mm, 0, 60e-6);
}

TEST(PlantAxis, FindsItsReferenceAgainWithinAFewNanometres) {
  const auto plant =
      warm_plant(2, {"axis.hold_min_nm=0", "axis.hold_max_nm=0", "room.ac_w_k=1e-9"});
  double square_nm2 = 0;
  constexpr int kTimes = 60;
  double first_nm = 0;
  for (int k = 0; k < kTimes; ++k) {
    plant->start_reference(0, at(20 * k));
    plant->axis(0, at(20 * k + 15));
    const double stage_nm = plant->truth(at(20 * k + 15)).geometry_nm;
    if (k == 0) first_nm = stage_nm;
    square_nm2 += (stage_nm - first_nm) * (stage_nm - first_nm);
  }
  // Differences of two references of 3 nm each, and the wander at rest: about 4.5 nm.
  const double spread_nm = std::sqrt(square_nm2 / (kTimes - 1));
  EXPECT_GT(spread_nm, 1.5);
  EXPECT_LT(spread_nm, 9);
}

TEST(PlantAxis, StartsAFifthOfASecondAfterTheCommand) {
  const auto plant = warm_plant();
  plant->start_move(0, 2, at(5));
  const AxisState before = plant->axis(0, at(5.1));
  EXPECT_FALSE(before.moving);
  EXPECT_FALSE(before.on_target);
  EXPECT_EQ(before.commanded_mm, 2);
  EXPECT_TRUE(plant->axis(0, at(5.3)).moving);
  const AxisState there = plant->axis(0, at(8));
  EXPECT_FALSE(there.moving);
  EXPECT_TRUE(there.on_target);
}

TEST(PlantAxis, ReadsInStepsOfFiveNanometres) {
  const auto plant = warm_plant();
  const double steps = plant->axis(0, at(1)).q_mm / 5e-6;
  EXPECT_NEAR(steps, std::round(steps), 1e-6);
}

TEST(PlantAxis, HoldsWithAnErrorOf25To35NanometresThatTheScaleSees) {
  const auto plant = warm_plant(6);
  plant->start_reference(0, at(0));
  double square_nm2 = 0, wander_nm2 = 0;
  int positive = 0;
  constexpr int kMoves = 200;
  for (int k = 0; k < kMoves; ++k) {
    const double start_s = 20 + 12 * k;
    const double target_mm = (k % 9) - 4;
    plant->start_move(0, target_mm, at(start_s));
    double first_nm = 0;
    for (int read = 0; read < 4; ++read) {
      plant->axis(0, at(start_s + 9 + 0.5 * read));
      const auto truth = plant->truth(at(start_s + 9 + 0.5 * read));
      const double error_nm = truth.q_scale_nm - truth.commanded_nm;
      square_nm2 += error_nm * error_nm / (4 * kMoves);
      if (read == 0) first_nm = error_nm;
      if (read == 3) wander_nm2 += (error_nm - first_nm) * (error_nm - first_nm) / kMoves;
    }
    if (first_nm > 0) ++positive;
  }
  EXPECT_GT(std::sqrt(square_nm2), 25);
  EXPECT_LT(std::sqrt(square_nm2), 35);
  EXPECT_LT(std::sqrt(wander_nm2), 3);  // slow within a group of readings
  EXPECT_GT(positive, kMoves / 3);      // on both sides
  EXPECT_LT(positive, 2 * kMoves / 3);
}

TEST(PlantAxis, StopsWhereItIsWhenHalted) {
  const auto plant = warm_plant();
  plant->start_move(0, 4, at(0));
  plant->halt_axis(0, at(0.9));
  const double stopped_mm = plant->axis(0, at(1.5)).q_mm;
  EXPECT_GT(stopped_mm, 0.1);
  EXPECT_LT(stopped_mm, 3.9);
  EXPECT_FALSE(plant->axis(0, at(1.5)).moving);
  EXPECT_NEAR(plant->axis(0, at(10)).q_mm, stopped_mm, 100e-6);
  EXPECT_NEAR(plant->axis(0, at(10)).commanded_mm, stopped_mm, 100e-6);
}

TEST(PlantAxis, ThatStandsDoesNotMoveWhenHalted) {
  const auto plant = warm_plant();
  plant->start_move(0, 1, at(0));
  const double there_mm = plant->axis(0, at(5)).q_mm;
  plant->halt_axis(0, at(5));
  EXPECT_FALSE(plant->axis(0, at(5.001)).moving);
  EXPECT_NEAR(plant->axis(0, at(10)).q_mm, there_mm, 100e-6);
}

// A controller begins a move a while after it took the command.
TEST(PlantAxis, ForgetsAMoveThatHasNotBegunWhenHalted) {
  const auto plant = warm_plant();
  plant->start_move(0, 4, at(0));
  plant->halt_axis(0, at(0.001));
  EXPECT_FALSE(plant->axis(0, at(5)).moving);
  EXPECT_NEAR(plant->axis(0, at(5)).q_mm, plant->axis(0, at(0)).q_mm, 100e-6);
}

TEST(PlantAxis, IsOffTargetWithoutServo) {
  const auto plant = warm_plant();
  plant->start_move(0, 1, at(0));
  EXPECT_TRUE(plant->axis(0, at(5)).on_target);
  plant->set_servo(0, false, at(5));
  EXPECT_FALSE(plant->axis(0, at(8)).on_target);
  EXPECT_NEAR(plant->axis(0, at(8)).q_mm, 0, 1e-4);  // the flexure's neutral position
}

}  // namespace
}  // namespace driftwise::simulated
