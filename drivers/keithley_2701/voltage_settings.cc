#include "drivers/keithley_2701/voltage_settings.h"

#include <algorithm>
#include <cmath>

#include "server/core/devices/role_settings.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/unit_conversion.h"
#include "server/core/units.h"

namespace driftwise::keithley {
namespace {

enum class Measures { angle, length, plate, force, motor_force };

// Channel of the sensor as its device needs it; the message names an example.
bool fits(Measures measures, const Channel& channel) {
  const auto symbol = without_robot(channel.symbol);
  const bool is_pose = is_pose_symbol(symbol);
  switch (measures) {
    case Measures::angle:
      return is_pose && symbol.front() == 'r' && channel.unit == "arcsec";
    case Measures::length:
      return is_pose && symbol.front() != 'r' && channel.unit == "mm";
    default:
      return channel.unit == "N";
  }
}

const char* example_of(Measures measures) {
  return measures == Measures::angle    ? "a rotation in arcsec such as rx_arcsec"
         : measures == Measures::length ? "a coordinate in mm such as z_mm"
                                        : "a force in N such as force_N";
}

// The factor from "deg/V" to the channel's unit per volt; an arcsine's is "1/V".
void read_slope(SettingsReader& reader, VoltageSensor& sensor) {
  std::string unit;
  reader.number("slope", sensor.slope, {}, Need::required);
  reader.text("slope_unit", unit, Need::required);
  if (sensor.slope == 0)
    reader.refuse("slope", reasons::kBadValue, "found 0, expected another number");
  const auto slash = unit.find('/');
  const bool is_ratio = sensor.curve == SensorCurve::arcsine;
  const std::string wanted = is_ratio ? "1" : sensor.channel.unit;
  const auto above =
      slash == std::string::npos
          ? Result<UnitConversion>(fail(ErrorCode::invalid_argument, reasons::kBadUnit, "no slash"))
          : unit_conversion(unit.substr(0, slash), wanted);
  const auto below =
      slash == std::string::npos ? above : unit_conversion("V", unit.substr(slash + 1));
  if (!above || !below || above->offset != 0 || below->offset != 0) {
    reader.refuse("slope_unit", reasons::kBadUnit,
                  "found " + shown(unit) + ", expected " +
                      (is_ratio ? "1/V: an arcsine's slope is the sine per volt"
                                : "a unit of " + sensor.channel.name() + " per volt, such as " +
                                      wanted + "/V"));
    return;
  }
  sensor.slope *= above->factor / above->divisor * below->factor / below->divisor;
}

void read_range(SettingsReader& reader, VoltageSensor& sensor) {
  reader.number("zero_v", sensor.zero_v, {.min = -1000, .max = 1000});
  reader.number("min_v", sensor.min_v, {.min = -1000, .max = 1000}, Need::required);
  reader.number("max_v", sensor.max_v, {.min = -1000, .max = 1000}, Need::required);
  reader.number("u", sensor.u, {.min = 0});
  if (!(sensor.min_v < sensor.max_v)) {
    reader.refuse("min_v", reasons::kBadLimits,
                  "found min_v = " + number_text(sensor.min_v) +
                      " and max_v = " + number_text(sensor.max_v) + ", expected min_v below max_v");
  } else if (std::isnan(range_of(sensor)[0])) {
    const double end_v =
        std::abs(sensor.min_v - sensor.zero_v) > std::abs(sensor.max_v - sensor.zero_v)
            ? sensor.min_v
            : sensor.max_v;
    reader.refuse("slope", reasons::kBadValue,
                  "found a sine of " + number_text(sensor.slope * (end_v - sensor.zero_v)) +
                      " at " + number_text(end_v) +
                      " V, expected at most 1: the voltages of min_v .. max_v are those of the "
                      "sensor's range");
  }
}

void read_sensor(SettingsReader& reader, Measures measures, VoltageSensor& sensor) {
  if (measures == Measures::plate) {
    sensor.channel.unit = "mm";
    reader.number("x_mm", sensor.x_mm, {.min = -1e4, .max = 1e4}, Need::required);
    reader.number("y_mm", sensor.y_mm, {.min = -1e4, .max = 1e4}, Need::required);
  } else {
    reader.channel("channel", sensor.channel, Need::required);
    if (!fits(measures, sensor.channel))
      reader.refuse("channel", reasons::kBadChannel,
                    "found " + shown(sensor.channel.name()) + ", expected " + example_of(measures));
    reader.give("channel", sensor.channel.name());
  }
  reader.integer("input", sensor.input, 101, 599, Need::required);
  std::string curve = "linear";
  reader.choice("curve", curve, {"linear", "arcsine"});
  sensor.curve = curve == "arcsine" ? SensorCurve::arcsine : SensorCurve::linear;
  if (sensor.curve == SensorCurve::arcsine && measures != Measures::angle)
    reader.refuse("curve", reasons::kBadValue,
                  "found \"arcsine\", expected \"linear\": only an angle is an arcsine");
  read_slope(reader, sensor);
  read_range(reader, sensor);
}

void read_sensors(SettingsReader& reader, Measures measures, VoltageSensors& out) {
  reader.each("sensor", [&](SettingsReader& one) {
    auto& sensor = out.sensors.emplace_back();
    read_sensor(one, measures, sensor);
    for (std::size_t i = 0; i + 1 < out.sensors.size(); ++i) {
      if (out.sensors[i].input != sensor.input) continue;
      one.refuse("input", reasons::kDuplicateChannel,
                 "found input " + std::to_string(sensor.input) +
                     ", which another sensor of this device has already");
    }
  });
  const std::size_t expected = measures == Measures::plate ? 3 : 1;
  const bool is_exact = measures == Measures::plate || measures == Measures::length ||
                        measures == Measures::motor_force;
  if (!out.sensors.empty() && is_exact && out.sensors.size() != expected)
    reader.refuse("sensor", reasons::kBadValue,
                  "found " + std::to_string(out.sensors.size()) + " sensors, expected " +
                      std::to_string(expected) +
                      (measures == Measures::plate ? ": three heights make a plane"
                                                   : ": one [[device]] for each"));
}

// z and the two tilts of a plate, in the channels' declared uncertainties those of the sensors.
LengthSettings read_plate(SettingsReader& reader, VoltageSensors& voltages) {
  voltages.is_plate = true;
  LengthSettings out;
  read_sensors(reader, Measures::plate, voltages);
  reader.channel("length", out.channel, Need::required);
  Channel rx, ry;
  reader.channel("tilt_x", rx, Need::required);
  reader.channel("tilt_y", ry, Need::required);
  const auto expect = [&](const char* key, const Channel& found, const char* symbol,
                          const char* unit) {
    if (without_robot(found.symbol) == symbol && found.unit == unit) return;
    reader.refuse(key, reasons::kBadChannel,
                  "found " + shown(found.name()) + ", expected " + symbol + "_" + unit +
                      ": the sensors look along z");
  };
  expect("length", out.channel, "z", "mm");
  expect("tilt_x", rx, "rx", "arcsec");
  expect("tilt_y", ry, "ry", "arcsec");
  if (voltages.sensors.size() == 3 && plate_area_mm2(voltages.sensors) == 0)
    reader.refuse("sensor", reasons::kBadValue,
                  "found three places x_mm, y_mm on one line, expected a triangle: a plane turns "
                  "about that line unseen");
  const auto u = plate_uncertainty(voltages.sensors);
  out.u_length_nm = std::isnan(u.z_mm) ? 0 : nm_from_mm(u.z_mm);
  out.angles = {{rx, 1, 1, std::isnan(u.rx_arcsec) ? 0 : u.rx_arcsec},
                {ry, 2, 1, std::isnan(u.ry_arcsec) ? 0 : u.ry_arcsec}};
  reader.give("length", out.channel.name());
  reader.give("tilt_x", rx.name());
  reader.give("tilt_y", ry.name());
  return out;
}

void read_motor(SettingsReader& reader, VoltageSensors& voltages) {
  auto& motor = voltages.motor.emplace();
  reader.channel("axis", motor.axis, Need::required);
  reader.number("friction_n", motor.friction_n, {.min = 0}, Need::required);
  reader.number("u_friction_n", motor.u_friction_n, {.min = 0});
  reader.number("travel_mm", motor.travel_mm, {.min = 0, .max = 1000, .above_min = true},
                Need::required);
  if (!is_motor_symbol(without_robot(motor.axis.symbol)))
    reader.refuse("axis", reasons::kBadChannel,
                  "found " + shown(motor.axis.name()) +
                      ", expected the motor coordinate that the motor moves, such as q3_mm");
}

}  // namespace

void read_settings(SettingsReader& reader, DeviceDescription& device) {
  std::string measures = "temperature";
  reader.choice("measures", measures,
                {"temperature", "angle", "length", "plate", "force", "motor-force"});
  if (measures == "temperature") return read_temperature_settings(reader, device);
  auto& voltages = device.voltages;
  if (measures == "angle") {
    read_sensors(reader, Measures::angle, voltages);
    AngleSettings settings;
    for (const auto& sensor : voltages.sensors)
      settings.angles.push_back(
          {sensor.channel, static_cast<int>(settings.angles.size()) + 1, 1, sensor.u});
    device.settings = std::move(settings);
  } else if (measures == "length") {
    read_sensors(reader, Measures::length, voltages);
    LengthSettings settings;
    if (!voltages.sensors.empty()) {
      settings.channel = voltages.sensors.front().channel;
      settings.u_length_nm = nm_from_mm(voltages.sensors.front().u);
    }
    device.settings = std::move(settings);
  } else if (measures == "plate") {
    device.settings = read_plate(reader, voltages);
  } else {
    if (measures == "motor-force") read_motor(reader, voltages);
    read_sensors(reader, voltages.motor ? Measures::motor_force : Measures::force, voltages);
    ForceSettings settings;
    for (const auto& sensor : voltages.sensors)
      settings.quantities.push_back({sensor.channel, sensor.u});
    device.settings = std::move(settings);
  }
}

std::vector<Channel> channels_of(const DeviceDescription& device) {
  auto out = channels_of_settings(device);
  for (auto& channel : voltage_channels(device.id, device.voltages))
    if (std::ranges::find(out, channel) == out.end()) out.push_back(std::move(channel));
  return out;
}

}  // namespace driftwise::keithley
