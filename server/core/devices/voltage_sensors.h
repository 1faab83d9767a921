#pragma once
// Sensors whose output is a voltage at an input of a scanner, and the quantities that the voltages
// are: [[device.sensor]] of a cell file (docs/devices/analogue.md). Pure.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/core/channel.h"

namespace driftwise {

enum class SensorCurve {
  linear,   // value = slope * (U - zero_v)
  arcsine,  // sin(value) = slope * (U - zero_v): an inclinometer that weighs against gravity
};

// One voltage.
struct VoltageSensor {
  Channel channel;  // rx_arcsec; of a plate's sensor: no symbol, unit mm
  int input = 0;    // scanner channel number, 101..
  SensorCurve curve = SensorCurve::linear;
  double slope = 0;             // linear: channel's unit per volt; arcsine: per volt
  double zero_v = 0;            // voltage at which the value is 0
  double min_v = 0, max_v = 0;  // outside there is no value
  double u = 0;                 // declared standard uncertainty, channel's unit
  double x_mm = 0, y_mm = 0;    // of a plate's sensor: place in the cell's frame
};

// Force of a motor by its current. Dry friction holds a part of it that depends on the direction of
// the axis' last motion: current * constant = force + direction * friction.
struct MotorFriction {
  Channel axis;             // q3_mm
  double friction_n = 0;    // half of the width of the hysteresis
  double u_friction_n = 0;  // standard uncertainty of the friction while the direction is known
  double travel_mm = 0;     // after a reversal the friction has turned round within this way
};

// Settings of one device; no sensors: it measures no voltage.
struct VoltageSensors {
  std::vector<VoltageSensor> sensors;
  bool is_plate = false;  // three sensors that look along z at one plane
  std::optional<MotorFriction> motor;
};

// NaN: the voltage is missing, or outside min_v .. max_v.
double value_from_volts(const VoltageSensor& sensor, double volts);
// The values at the ends of the sensor's range, the lower one first.
std::array<double, 2> range_of(const VoltageSensor& sensor);

// A plane over the cell's origin. Rotations by rx about x, then by ry about y, right-handed.
struct PlatePose {
  double z_mm = 0, rx_arcsec = 0, ry_arcsec = 0;
};
// heights_mm: of the plane at the places of the three sensors. NaN where one of them is NaN, or
// where the places lie on one line.
PlatePose plate_pose(std::span<const VoltageSensor> sensors, std::span<const double> heights_mm);
// Standard uncertainties from those of the sensors, about the level plate.
PlatePose plate_uncertainty(std::span<const VoltageSensor> sensors);
// Twice the area of the triangle of the places: 0 when they lie on one line.
double plate_area_mm2(std::span<const VoltageSensor> sensors);

// Force at the end-effector and its standard uncertainty. A direction of 0 is one that is not
// known: then the force is anywhere within the friction, a rectangle.
struct MotorForce {
  double newton = 0, u_n = 0;
  bool in_dead_band = false;
};
MotorForce motor_force(double motor_n, double u_n, const MotorFriction& friction, int direction);

// Direction in which the friction of an axis is pulled, from its readback. Play of travel_mm: after
// a reversal the direction is 0 until the axis has gone so far the other way.
class FrictionDirection {
 public:
  explicit FrictionDirection(double travel_mm) : travel_mm_(travel_mm) {}
  void moved_to(double q_mm);
  int now() const;  // 1, -1; 0: not known
  void forget() { begun_ = false; }

 private:
  double travel_mm_;
  bool begun_ = false;
  int direction_ = 0;
  // Farthest place in the direction; at the beginning both ends of what was seen.
  double farthest_mm_ = 0, low_mm_ = 0, high_mm_ = 0, q_mm_ = 0;
};

// What a device with these settings gives besides the channels of its role: level_201_V per sensor;
// of a motor also <symbol>_u_N and <symbol>_dead_band_1.
std::vector<Channel> voltage_channels(const std::string& device, const VoltageSensors& sensors);
Channel voltage_channel(const std::string& device, const VoltageSensor& sensor);

}  // namespace driftwise
