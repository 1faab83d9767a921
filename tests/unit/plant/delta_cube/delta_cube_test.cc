// The simulated Delta Cube 2 against what is known from outside: the closed form of its kinematics,
// the published box, the physics of an opened one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/simulated/plant/file/make_plant.h"
#include "drivers/simulated/plant/numbers/units.h"
#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

const std::string kDeltaCubeFile = DRIFTWISE_SOURCE_DIR "/deploy/cells/delta-cube-2/plant.toml";

struct WarmDeltaCube {
  explicit WarmDeltaCube(std::vector<std::string> overrides = {}) {
    overrides.insert(overrides.begin(), {"plant.step_s=0.5", "plant.start_hours_before=6.0"});
    plant = make_delta_cube_plant(kDeltaCubeFile,
                                  {.seed = 7, .overrides = overrides, .epoch_ns = kEpoch});
    for (int i = 0; i < 3; ++i) plant->start_reference(i, at(time_s));
    pass(20);
  }
  void pass(double seconds) { plant->advance_to(at(time_s += seconds)); }
  DeltaCubePlant::Pose go(double q1, double q2, double q3) {
    plant->start_move(0, q1, at(time_s));
    plant->start_move(1, q2, at(time_s));
    plant->start_move(2, q3, at(time_s));
    pass(10);
    return plant->pose(time_s);
  }
  double value(const std::string& name) {
    const auto columns = plant->truth_columns();
    const auto place = std::find(columns.begin(), columns.end(), name) - columns.begin();
    return plant->truth_values(at(time_s))[static_cast<std::size_t>(place)];
  }
  std::unique_ptr<DeltaCubePlant> plant;
  double time_s = 0;
};

// A machine without errors of workshop and assembly.
const std::vector<std::string> kIdeal{"tolerance.column_mm=0",  "tolerance.guide_mrad=0",
                                      "tolerance.mount_mrad=0", "tolerance.skew_mrad=0",
                                      "tolerance.joint_mm=0",   "tolerance.bar_mm=0",
                                      "tolerance.leg_mm=0",     "tolerance.scale_ppm=0"};

TEST(DeltaCubePlant, FollowsTheClosedFormOfItsKinematicsWithoutTolerances) {
  WarmDeltaCube robot(kIdeal);
  const auto zero = robot.go(0, 0, 0);
  const auto far = robot.go(1.5, -1.2, 0.9);
  const double length_mm = 60;
  // q1 = x - L + sqrt(L^2 - y^2 - z^2), and round: solved for the pose by fixed-point iteration.
  double p[3] = {1.5, -1.2, 0.9};
  const double q[3] = {1.5, -1.2, 0.9};
  for (int round = 0; round < 50; ++round)
    for (int i = 0; i < 3; ++i) {
      const double a = p[(i + 1) % 3], b = p[(i + 2) % 3];
      p[i] = q[i] + length_mm - std::sqrt(length_mm * length_mm - a * a - b * b);
    }
  for (std::size_t i = 0; i < 3; ++i) {
    const double moved_nm = far.position_nm[i] - zero.position_nm[i];
    // Beyond the closed form: parabolic guides (1.8 mm on 60 mm legs draw in by 32 um, which swings
    // an arm by 1.5 in 60: 0.8 um), give of the blades, holding errors of 35 nm.
    EXPECT_NEAR(moved_nm, p[i] * kNmPerMm, 2000) << "axis " << i;
    EXPECT_NEAR(far.rotation_arcsec[i], zero.rotation_arcsec[i], 3) << "axis " << i;
  }
}

TEST(DeltaCubePlant, TurnsByTensOfArcsecondsAsAFlexureDeltaDoes) {
  WarmDeltaCube robot;
  const auto zero = robot.go(0, 0, 0);
  double largest = 0;
  for (const double a : {-1.8, 1.8})
    for (const double b : {-1.8, 1.8})
      for (const double c : {-1.8, 1.8}) {
        const auto there = robot.go(a, b, c);
        for (std::size_t i = 0; i < 3; ++i)
          largest = std::max(largest, std::abs(there.rotation_arcsec[i] - zero.rotation_arcsec[i]));
      }
  // The study's deltas turn by at most 50 arcsec; beyond 200 the light is lost.
  EXPECT_GT(largest, 1);
  EXPECT_LT(largest, 100);
}

TEST(DeltaCubePlant, KeepsItsBoxAtTwentyFiveDegrees) {
  WarmDeltaCube robot({"plant.start_hours_before=12.0"});
  double low = 100, high = 0;
  for (int minute = 0; minute < 120; ++minute) {
    robot.pass(60);
    low = std::min(low, robot.value("box_air_degC"));
    high = std::max(high, robot.value("box_air_degC"));
  }
  // "25.00 +-0.01 degC": two standard deviations of its thermometer, so rarely somewhat beyond.
  EXPECT_GT(low, 24.975);
  EXPECT_LT(high, 25.025);
}

TEST(DeltaCubePlant, CoolsWhenItsBoxIsOpenedAndIsStableAgainAfterNineHours) {
  WarmDeltaCube robot({"plant.start_hours_before=12.0"});
  const double before_degc = robot.value("frame_1_degC");
  ASSERT_TRUE(robot.plant->open_box(1800, at(robot.time_s)));
  robot.pass(1790);
  // The room is 3 K colder; half an hour of the frame's time constant of an hour and more.
  EXPECT_LT(robot.value("box_air_degC"), 24.5);
  EXPECT_LT(robot.value("frame_1_degC"), before_degc - 0.05);
  robot.pass(9 * 3600.0 + 10);
  EXPECT_NEAR(robot.value("frame_1_degC"), before_degc, 0.02);
}

TEST(DeltaCubePlant, SeesRotationAboutYTwice) {
  WarmDeltaCube robot;
  const auto read = [&](int device, bool z_axis) {
    double sum = 0;
    for (int i = 0; i < 50; ++i) {
      robot.pass(0.2);
      const auto reading = robot.plant->measure_angle(device, 0.1, at(robot.time_s));
      sum += z_axis ? reading.z_arcsec : reading.y_arcsec;
    }
    return sum / 50;
  };
  robot.go(0, 0, 0);
  const double along_x_zero = read(0, false), along_z_zero = read(1, true);
  const auto zero = robot.plant->pose(robot.time_s);
  robot.go(1.8, 1.8, -1.8);
  const double turned =
      robot.plant->pose(robot.time_s).rotation_arcsec[1] - zero.rotation_arcsec[1];
  // Gains of 0.1 %, rolls of 2 mrad on tens of arcsec, drift of a tenth.
  EXPECT_NEAR(read(0, false) - along_x_zero, turned, 0.5);
  EXPECT_NEAR(read(1, true) - along_z_zero, turned, 0.5);
}

TEST(OtherPlants, HaveNoBoxToOpen) {
  const auto axis =
      make_plant(DRIFTWISE_SOURCE_DIR "/deploy/cells/linear-axis/plant.toml",
                 {.seed = 1, .overrides = {"plant.start_hours_before=1.0"}, .epoch_ns = kEpoch});
  EXPECT_FALSE(axis->open_box(10, kEpoch));
}

}  // namespace
}  // namespace driftwise::simulated
