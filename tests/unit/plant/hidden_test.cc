// What [hidden] does to a plant: each mechanism against a figure worked out by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

// Nothing that moves by itself: what is left is what is hidden.
std::vector<std::string> quiet(std::vector<std::string> hidden) {
  std::vector<std::string> overrides{"room.schedule=[[0.0833, 20.0]]",
                                     "room.wander_w=0",
                                     "room.cycle_w=0",
                                     "room.turbulence_k=0",
                                     "room.pressure_wander_hpa=0",
                                     "room.humidity_wander_pct=0",
                                     "interferometer.vibration_nm=0",
                                     "interferometer.instability_nm=0",
                                     "interferometer.beam_turbulence_k=0",
                                     "interferometer.disturbances_per_hour=0",
                                     "axis.hold_min_nm=0",
                                     "axis.hold_max_nm=0",
                                     "axis.hold_wander_nm=0",
                                     "axis.hold_jitter_nm=0",
                                     "axis.ring_nm_per_mm_s2=0",
                                     "axis.reference_repeatability_nm=0"};
  overrides.insert(overrides.end(), hidden.begin(), hidden.end());
  return overrides;
}

double length_nm(LinearAxisPlant& plant, double time_s) {
  return plant.measure_length(0, at(time_s), 2048).mean_nm;
}

// The same story with and without what is hidden: the difference of the lengths.
class HiddenOnTheAxis {
 public:
  explicit HiddenOnTheAxis(const std::string& hidden)
      : bare_(warm_plant(1, quiet({}))), hiding_(warm_plant(1, quiet({hidden}))) {
    each([](LinearAxisPlant& plant) {
      plant.start_reference(0, at(1));
      plant.start_move(0, 0, at(15));
      plant.zero_length(0, at(18));
    });
  }
  template <class Do>
  void each(Do what) {
    what(*bare_);
    what(*hiding_);
  }
  void move(double target_mm, double time_s) {
    each([&](LinearAxisPlant& plant) { plant.start_move(0, target_mm, at(time_s)); });
  }
  double added_nm(double time_s) { return length_nm(*hiding_, time_s) - length_nm(*bare_, time_s); }
  LinearAxisPlant& hiding() { return *hiding_; }

 private:
  std::unique_ptr<LinearAxisPlant> bare_, hiding_;
};

TEST(HiddenFriction, LeavesTheStageBehindOnEitherSide) {
  // 0.5 N over 10 N/um: 50 nm either way, 100 nm between the two approaches.
  HiddenOnTheAxis axis(
      "hidden.rub={kind=\"friction\",axis=1,friction_n=0.5,stiffness_n_um=10,presliding_um=1}");
  axis.move(1, 30);
  const double upwards_nm = axis.added_nm(40);
  axis.move(-1, 50);
  axis.move(0.5, 60);
  axis.move(0, 70);
  const double downwards_nm = axis.added_nm(80);
  EXPECT_NEAR(downwards_nm - upwards_nm, 100, 1);
}

TEST(HiddenViscoelastic, ComesLateByItsShareOfTheMove) {
  HiddenOnTheAxis axis(
      "hidden.glue={kind=\"viscoelastic\",axis=1,share_ppm=60,times_s=[3,30,300]}");
  axis.move(2, 3000);  // 2 mm x 60 ppm = 120 nm late at first
  const double early_nm = axis.added_nm(3001), late_nm = axis.added_nm(3060);
  EXPECT_LT(early_nm, -90);
  // One element is gone, the second at exp(-2), the third at exp(-0.2).
  EXPECT_NEAR(late_nm, -40 * (std::exp(-2.0) + std::exp(-0.2)), 4);
}

TEST(HiddenScaleSignals, RepeatWithTheScalesPeriod) {
  HiddenOnTheAxis axis(
      "hidden.signals={kind=\"scale_signals\",axis=1,period_nm=2000,offset_pct=4,amplitude_pct=0,"
      "phase_deg=0}");
  axis.move(0.0005, 30);  // a quarter of a period: offset / (2 pi) of it
  const double quarter_nm = axis.added_nm(40);
  axis.move(1.0005, 50);  // 500 periods on
  EXPECT_NEAR(std::abs(quarter_nm), 0.04 * 2000 / (2 * std::numbers::pi), 1);
  EXPECT_NEAR(axis.added_nm(60), quarter_nm, 1.5);
}

TEST(HiddenFringes, RepeatWithHalfAWave) {
  HiddenOnTheAxis axis("hidden.ghost={kind=\"fringe_mixing\",beam=1,ghost=0.05,mixing=0}");
  double low_nm = 0, high_nm = 0;
  for (int k = 0; k <= 20; ++k) {
    axis.move(k * 316.5e-6 / 20, 30 + 5 * k);
    const double nm = axis.added_nm(33 + 5 * k);
    low_nm = std::min(low_nm, nm);
    high_nm = std::max(high_nm, nm);
  }
  // Peak to peak 2 x 0.05 of a radian.
  EXPECT_NEAR(high_nm - low_nm, 2 * 0.05 * 316.5 / (2 * std::numbers::pi), 0.3);
}

TEST(HiddenLaser, MakesTheWholePathDriftAsItWarmsUp) {
  HiddenOnTheAxis axis("hidden.tube={kind=\"laser_drift\",beam=1,ppm=1,warm_up_h=0.5}");
  // 40 mm of dead path x 1 ppm x (1 - exp(-2)), less the 18 s before the zero.
  EXPECT_NEAR(axis.added_nm(3600), -40 * (std::exp(-18 / 1800.0) - std::exp(-2.0)), 0.5);
}

TEST(HiddenLostFringe, JumpsByHalfWaves) {
  HiddenOnTheAxis axis("hidden.fringe={kind=\"lost_fringe\",beam=1,at_h=0.5,half_waves=1}");
  EXPECT_NEAR(axis.added_nm(1790), 0, 1e-6);
  EXPECT_NEAR(axis.added_nm(1810), 316.5, 1e-6);
}

TEST(HiddenDeadPath, ReadsThePressureAsALength) {
  const std::string front = "hidden.front={kind=\"weather_front\",at_h=1,over_h=0.5,hpa=-8}";
  HiddenOnTheAxis axis(front);
  // 0.27 ppm/hPa (Edlen) x 8 hPa x 40 mm: the device knows the pressure of the set-up only.
  EXPECT_NEAR(axis.added_nm(7200), -8 * 0.27e-6 * 40e6, 4);
}

TEST(HiddenSlab, FollowsItsPartLate) {
  const std::string slab =
      "hidden.slab={kind=\"slab\",axis=1,part=\"cover_air\",material=\"steel\",thickness_mm=10,"
      "film_w_m2k=20,length_mm=40}";
  auto hiding = warm_plant(1, {slab});  // the room goes up by 2 K from the fifth minute on
  const auto columns = hiding->truth_columns();
  ASSERT_EQ(columns.back(), "hidden_slab_nm");
  // rho c d / h = 7850 x 480 x 0.01 / 20 = 1884 s: 480 nm/K x less than the air's rise.
  const double start_nm = hiding->truth_values(at(300)).back();
  const double start_degc = hiding->truth(at(300)).air_degc;
  hiding->advance_to(at(1800));
  const double risen_k = hiding->truth(at(1800)).air_degc - start_degc;
  const double grown_nm = hiding->truth_values(at(1800)).back() - start_nm;
  EXPECT_GT(grown_nm, 0.1 * 480 * risen_k);
  EXPECT_LT(grown_nm, 0.7 * 480 * risen_k);
}

TEST(HiddenMotorHeat, ComesWithTravelAndGoesWithRest) {
  HiddenOnTheAxis axis(
      "hidden.drive={kind=\"motor_heat\",axis=1,part=\"base_top\",material=\"aluminium\","
      "heat_j_per_mm=0.3,drive_j_k=20,carrier_j_k=20,link_w_k=0.2,sink_w_k=0.04,length_mm=30}");
  for (int k = 0; k < 120; ++k) axis.move(k % 2 == 0 ? 0.5 : -0.5, 30 + 10 * k);
  const double warm_nm = axis.added_nm(1230);
  EXPECT_GT(std::abs(warm_nm), 100);
  EXPECT_LT(std::abs(axis.added_nm(1230 + 4 * 1200)), 0.2 * std::abs(warm_nm));
}

TEST(HiddenThermometers, StickJumpStretchAndSwap) {
  const auto fault = [](const std::string& text) {
    return warm_plant(1, {"hidden.probe={kind=\"thermometer\",input=107,at_h=0.5," + text + "}"});
  };
  const auto good = warm_plant(1);
  const auto stuck = fault("fault=\"stuck\""), loose = fault("fault=\"jump\",ohm=0.4");
  const auto swapped = fault("fault=\"swapped\",other=108");
  for (auto* plant : {good.get(), stuck.get(), loose.get(), swapped.get()}) {
    plant->probe_ohm(107, at(1700));
  }
  const double frozen_ohm = stuck->probe_ohm(107, at(1900));
  EXPECT_EQ(stuck->probe_ohm(107, at(3600)), frozen_ohm);
  EXPECT_NEAR(loose->probe_ohm(107, at(3600)) - good->probe_ohm(107, at(3600)), 0.4, 0.01);
  EXPECT_NEAR(swapped->probe_ohm(108, at(3600)), good->probe_ohm(107, at(3600)), 0.01);
}

TEST(HiddenSections, SayWhatIsWrong) {
  const auto refused = [](const std::string& text) {
    try {
      warm_plant(1, {text});
    } catch (const PlantFileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused("hidden.a={kind=\"glue\"}").find("expected one of: ball_contact"),
            std::string::npos);
  EXPECT_NE(refused("hidden.a={kind=\"slip\",axis=2,at_h=1,nm=5}").find("from 1 to 1"),
            std::string::npos);
  EXPECT_NE(refused("hidden.a={kind=\"slip\",axis=1,at_h=1,nm=5,mm=2}").find("means nothing"),
            std::string::npos);
  EXPECT_NE(refused("hidden.a.kind=slip").find("found nothing"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::simulated
