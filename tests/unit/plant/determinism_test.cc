#include <gtest/gtest.h>

#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

TEST(PlantTime, TemperaturesDoNotDependOnWhoAsksWhen) {
  const auto busy = warm_plant(7);
  const auto lazy = warm_plant(7);
  for (double time_s = 0.037; time_s < 1800; time_s += 0.731) {
    busy->probe_ohm(101, at(time_s));
    busy->stabiliser(0, at(time_s));
    busy->axis(0, at(time_s));
  }
  busy->advance_to(at(1800.05));
  lazy->advance_to(at(1800.05));
  EXPECT_EQ(busy->truth(at(1800)).node_degc, lazy->truth(at(1800)).node_degc);
  EXPECT_EQ(busy->truth(at(1800)).pressure_hpa, lazy->truth(at(1800)).pressure_hpa);
}

TEST(PlantTime, SameSeedAndCallsGiveTheSameReadings) {
  const auto one = warm_plant(8);
  const auto other = warm_plant(8);
  for (auto* plant : {one.get(), other.get()}) plant->start_reference(0, at(1));
  for (double time_s = 10; time_s < 20; time_s += 1) {
    EXPECT_EQ(one->axis(0, at(time_s)).q_mm, other->axis(0, at(time_s)).q_mm);
    EXPECT_EQ(one->measure_length(0, at(time_s), 2048).mean_nm,
              other->measure_length(0, at(time_s), 2048).mean_nm);
    EXPECT_EQ(one->probe_ohm(104, at(time_s + 0.6)), other->probe_ohm(104, at(time_s + 0.6)));
  }
}

TEST(PlantTime, AnotherSeedIsAnotherDay) {
  const auto one = warm_plant(1);
  const auto other = warm_plant(2);
  EXPECT_NE(one->truth(at(0)).node_degc, other->truth(at(0)).node_degc);
}

TEST(PlantTime, AnEarlierInstantIsAnsweredAsNow) {
  const auto plant = warm_plant();
  plant->start_move(0, 2, at(10));
  plant->axis(0, at(20));
  EXPECT_NEAR(plant->axis(0, at(10)).q_mm, 2, 1e-4);
}

TEST(PlantTime, AnIntervalThatWasMeasuredLateStillShowsThatInterval) {
  const auto plant = warm_plant(1, {"interferometer.disturbances_per_hour=0"});
  plant->start_move(0, 1, at(0));
  plant->start_move(0, 3, at(30));
  plant->advance_to(at(60));
  const double early_nm = plant->measure_length(0, at(20), 2048).mean_nm;
  const double late_nm = plant->measure_length(0, at(50), 2048).mean_nm;
  EXPECT_NEAR(late_nm - early_nm, 2e6, 2000);
}

}  // namespace
}  // namespace driftwise::simulated
