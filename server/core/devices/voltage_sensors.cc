#include "server/core/devices/voltage_sensors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/core/devices/device_description.h"
#include "server/core/unit_conversion.h"

namespace driftwise {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kArcsecPerRad = 648000 / std::numbers::pi;

double from_rad(double rad, const std::string& unit) {
  const auto conversion = unit_conversion("rad", unit);
  return conversion ? (*conversion)(rad) : kNone;
}

double unlimited_value(const VoltageSensor& sensor, double volts) {
  const double linear = sensor.slope * (volts - sensor.zero_v);
  if (sensor.curve == SensorCurve::linear) return linear;
  return std::abs(linear) <= 1 ? from_rad(std::asin(linear), sensor.channel.unit) : kNone;
}

// The plane h = at_origin + along_x * x + along_y * y through three places.
struct PlateSlopes {
  double at_origin = 0, along_x = 0, along_y = 0;
};

PlateSlopes slopes_through(std::span<const VoltageSensor> s, std::span<const double> h) {
  const double area = plate_area_mm2(s);
  const double h2 = h[1] - h[0], h3 = h[2] - h[0];
  const double x2 = s[1].x_mm - s[0].x_mm, x3 = s[2].x_mm - s[0].x_mm;
  const double y2 = s[1].y_mm - s[0].y_mm, y3 = s[2].y_mm - s[0].y_mm;
  PlateSlopes out;
  out.along_x = (h2 * y3 - h3 * y2) / area;
  out.along_y = (x2 * h3 - x3 * h2) / area;
  out.at_origin = h[0] - out.along_x * s[0].x_mm - out.along_y * s[0].y_mm;
  return out;
}

}  // namespace

double value_from_volts(const VoltageSensor& sensor, double volts) {
  if (!(volts >= sensor.min_v && volts <= sensor.max_v)) return kNone;
  return unlimited_value(sensor, volts);
}

std::array<double, 2> range_of(const VoltageSensor& sensor) {
  const double a = value_from_volts(sensor, sensor.min_v);
  const double b = value_from_volts(sensor, sensor.max_v);
  return {std::min(a, b), std::max(a, b)};
}

double plate_area_mm2(std::span<const VoltageSensor> s) {
  if (s.size() != 3) return 0;
  return (s[1].x_mm - s[0].x_mm) * (s[2].y_mm - s[0].y_mm) -
         (s[2].x_mm - s[0].x_mm) * (s[1].y_mm - s[0].y_mm);
}

PlatePose plate_pose(std::span<const VoltageSensor> sensors, std::span<const double> heights_mm) {
  if (plate_area_mm2(sensors) == 0 || heights_mm.size() != sensors.size())
    return {kNone, kNone, kNone};
  const auto plane = slopes_through(sensors, heights_mm);
  // The normal Ry Rx e_z: h = z - tan(ry) x + tan(rx) / cos(ry) y.
  const double ry = -std::atan(plane.along_x);
  const double rx = std::atan(plane.along_y * std::cos(ry));
  return {plane.at_origin, rx * kArcsecPerRad, ry * kArcsecPerRad};
}

PlatePose plate_uncertainty(std::span<const VoltageSensor> sensors) {
  PlatePose squares;
  if (plate_area_mm2(sensors) == 0) return {kNone, kNone, kNone};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    std::array<double, 3> raised{};
    raised[i] = sensors[i].u;
    const auto plane = slopes_through(sensors, raised);
    squares.z_mm += plane.at_origin * plane.at_origin;
    squares.rx_arcsec += plane.along_y * plane.along_y;
    squares.ry_arcsec += plane.along_x * plane.along_x;
  }
  return {std::sqrt(squares.z_mm), std::sqrt(squares.rx_arcsec) * kArcsecPerRad,
          std::sqrt(squares.ry_arcsec) * kArcsecPerRad};
}

MotorForce motor_force(double motor_n, double u_n, const MotorFriction& friction, int direction) {
  if (std::isnan(motor_n)) return {kNone, kNone, false};
  if (direction ==
      0)  // GUM 4.3.7: a rectangle of half-width a has the standard deviation a / sqrt 3
    return {motor_n, std::hypot(u_n, friction.friction_n / std::numbers::sqrt3), true};
  return {motor_n - direction * friction.friction_n, std::hypot(u_n, friction.u_friction_n), false};
}

void FrictionDirection::moved_to(double q_mm) {
  if (!begun_) {
    begun_ = true;
    direction_ = 0;
    low_mm_ = high_mm_ = q_mm;
  }
  q_mm_ = q_mm;
  if (direction_ == 0) {
    low_mm_ = std::min(low_mm_, q_mm);
    high_mm_ = std::max(high_mm_, q_mm);
    if (q_mm - low_mm_ > travel_mm_) direction_ = 1;
    if (high_mm_ - q_mm > travel_mm_) direction_ = -1;
    farthest_mm_ = q_mm;
    return;
  }
  if (direction_ * (q_mm - farthest_mm_) > 0) farthest_mm_ = q_mm;
  if (direction_ * (farthest_mm_ - q_mm) > travel_mm_) {
    direction_ = -direction_;
    farthest_mm_ = q_mm;
  }
}

int FrictionDirection::now() const {
  // A quarter of the way back is within the servo's holding error of a reversal that is none.
  constexpr double kHolding = 0.25;
  return begun_ && direction_ * (farthest_mm_ - q_mm_) <= kHolding * travel_mm_ ? direction_ : 0;
}

Channel voltage_channel(const std::string& device, const VoltageSensor& sensor) {
  return {symbol_from_id(device) + "_" + std::to_string(sensor.input), "V"};
}

std::vector<Channel> voltage_channels(const std::string& device, const VoltageSensors& voltages) {
  std::vector<Channel> out;
  for (const auto& sensor : voltages.sensors) out.push_back(voltage_channel(device, sensor));
  if (voltages.motor && !voltages.sensors.empty()) {
    const auto& force = voltages.sensors.front().channel;
    out.push_back({force.symbol + "_u", force.unit});
    out.push_back({force.symbol + "_dead_band", "1"});
  }
  return out;
}

}  // namespace driftwise
