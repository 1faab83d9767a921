#include "server/core/devices/voltage_sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace driftwise {
namespace {

constexpr double kArcsecPerDeg = 3600;

VoltageSensor sensor_of(double slope, double min_v, double max_v) {
  VoltageSensor out;
  out.channel = {"z", "mm"};
  out.input = 201;
  out.slope = slope;
  out.min_v = min_v;
  out.max_v = max_v;
  return out;
}

TEST(VoltageSensor, IsLinearWithinItsRangeAndHasNoValueBeyondIt) {
  auto gauge = sensor_of(0.5, 0.5, 9.5);
  gauge.zero_v = 5;
  EXPECT_DOUBLE_EQ(value_from_volts(gauge, 6), 0.5);
  EXPECT_DOUBLE_EQ(value_from_volts(gauge, 0.5), -2.25);
  EXPECT_TRUE(std::isnan(value_from_volts(gauge, 0.49)));
  EXPECT_TRUE(std::isnan(value_from_volts(gauge, 9.51)));
  EXPECT_TRUE(std::isnan(value_from_volts(gauge, std::nan(""))));
}

// +-5 V at +-20 deg: a servo inclinometer gives 5 V / sin(20 deg) per unit of the sine.
TEST(VoltageSensor, OfAnInclinometerIsTheArcsineOfItsVoltage) {
  VoltageSensor level;
  level.channel = {"rx", "arcsec"};
  level.curve = SensorCurve::arcsine;
  level.slope = std::sin(20 * std::numbers::pi / 180) / 5;
  level.min_v = -5;
  level.max_v = 5;
  EXPECT_NEAR(value_from_volts(level, 5), 20 * kArcsecPerDeg, 1e-6);
  // Hand-worked: x = 0.1 sin 20 deg = 0.0342020, x + x^3/6 = 0.0342087 rad = 1.96001 deg. A
  // straight line would say 2 deg.
  EXPECT_NEAR(value_from_volts(level, 0.5) / kArcsecPerDeg, 1.96001, 1e-5);
  EXPECT_NEAR(range_of(level)[0], -20 * kArcsecPerDeg, 1e-6);
}

std::vector<VoltageSensor> triangle() {
  std::vector<VoltageSensor> out(3, sensor_of(1, -10, 10));
  out[0].x_mm = 40, out[0].y_mm = 0;
  out[1].x_mm = -20, out[1].y_mm = 35;
  out[2].x_mm = -20, out[2].y_mm = -35;
  return out;
}

// A point r of the plate goes to Ry Rx r + z; the sensor at (x, y) sees where its line meets it.
double height_mm(double z_mm, double rx, double ry, double x_mm, double y_mm) {
  const double nx = std::cos(rx) * std::sin(ry), ny = -std::sin(rx);
  const double nz = std::cos(rx) * std::cos(ry);
  return z_mm - (nx * x_mm + ny * y_mm) / nz;
}

TEST(Plate, IsFoundFromThreeHeightsAtAnyTilt) {
  const auto sensors = triangle();
  for (const double rx_deg : {-5.0, 0.0, 3.0})
    for (const double ry_deg : {-4.0, 0.0, 6.0}) {
      const double rx = rx_deg * std::numbers::pi / 180, ry = ry_deg * std::numbers::pi / 180;
      std::vector<double> heights;
      for (const auto& one : sensors) heights.push_back(height_mm(0.7, rx, ry, one.x_mm, one.y_mm));
      const auto pose = plate_pose(sensors, heights);
      EXPECT_NEAR(pose.z_mm, 0.7, 1e-12);
      EXPECT_NEAR(pose.rx_arcsec, rx_deg * kArcsecPerDeg, 1e-7);
      EXPECT_NEAR(pose.ry_arcsec, ry_deg * kArcsecPerDeg, 1e-7);
    }
}

TEST(Plate, TurnsRightHanded) {
  const auto sensors = triangle();
  const auto pose = plate_pose(sensors, std::vector{0.0, 0.035, -0.035});  // +y goes up
  EXPECT_GT(pose.rx_arcsec, 0);
  EXPECT_LT(plate_pose(sensors, std::vector{0.04, -0.02, -0.02}).ry_arcsec, 0);  // +x goes up
}

TEST(Plate, HasNoPoseWhereASensorHasNoValueOrThePlacesLieOnOneLine) {
  auto sensors = triangle();
  EXPECT_TRUE(std::isnan(plate_pose(sensors, std::vector{0.0, std::nan(""), 0.0}).z_mm));
  for (auto& one : sensors) one.y_mm = 0;
  EXPECT_TRUE(std::isnan(plate_pose(sensors, std::vector{0.0, 0.0, 0.0}).rx_arcsec));
}

// Equal sensors at the corners of a triangle about the origin: z is their mean; rx a difference
// over 70 mm.
TEST(Plate, HasTheUncertaintyOfItsSensorsOverTheirLevers) {
  auto sensors = triangle();
  for (auto& one : sensors) one.u = 0.0003;
  const auto u = plate_uncertainty(sensors);
  EXPECT_NEAR(u.z_mm, 0.0003 / std::sqrt(3.0), 1e-9);
  const double arcsec = 648000 / std::numbers::pi;
  EXPECT_NEAR(u.rx_arcsec, 0.0003 * std::sqrt(2.0) / 70 * arcsec, 1e-6);
  EXPECT_NEAR(u.ry_arcsec, 0.0003 * std::sqrt(1.5) / 60 * arcsec, 1e-6);
}

const MotorFriction kFriction{{"q1", "mm"}, 0.3, 0.02, 0.01};

TEST(MotorForce, LosesTheFrictionOfAKnownDirection) {
  const auto up = motor_force(2.3, 0.01, kFriction, 1);
  EXPECT_DOUBLE_EQ(up.newton, 2.0);
  EXPECT_NEAR(up.u_n, std::hypot(0.01, 0.02), 1e-12);
  EXPECT_FALSE(up.in_dead_band);
  EXPECT_DOUBLE_EQ(motor_force(1.7, 0.01, kFriction, -1).newton, 2.0);
}

TEST(MotorForce, IsARectangleOfTheFrictionWhereTheDirectionIsNotKnown) {
  const auto within = motor_force(2.1, 0, kFriction, 0);
  EXPECT_DOUBLE_EQ(within.newton, 2.1);
  EXPECT_NEAR(within.u_n, 0.3 / std::sqrt(3.0), 1e-12);  // GUM 4.3.7
  EXPECT_TRUE(within.in_dead_band);
}

TEST(FrictionDirection, IsKnownOnceTheAxisHasGoneItsWay) {
  FrictionDirection direction(0.01);
  EXPECT_EQ(direction.now(), 0);
  direction.moved_to(5);
  EXPECT_EQ(direction.now(), 0) << "where it came from is not known";
  direction.moved_to(5.02);
  EXPECT_EQ(direction.now(), 1);
  direction.moved_to(5.0195);
  EXPECT_EQ(direction.now(), 1) << "the servo holds, that is no reversal";
  direction.moved_to(5.014);
  EXPECT_EQ(direction.now(), 0) << "the friction is turning round";
  direction.moved_to(5.005);
  EXPECT_EQ(direction.now(), -1);
  direction.forget();
  EXPECT_EQ(direction.now(), 0);
}

}  // namespace
}  // namespace driftwise
