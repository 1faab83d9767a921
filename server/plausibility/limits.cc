#include "server/plausibility/limits.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace driftwise::plausibility {
namespace {

// A laboratory and its instruments: the operating range of scanners and interferometers.
constexpr double kColdest_degc = 0, kWarmest_degc = 60;
// A pt1000 on a part of steel or aluminium follows it: a heater of 1 kW warms 10 kg by 0.2 K/s at
// most, a room moves its parts a thousand times slower.
constexpr double kPartStep_k = 0.2, kPart_k_per_s = 0.005;
// Air, by an opened door.
constexpr double kAirStep_k = 2.0, kAir_k_per_s = 0.1;
// A Peltier element on a support of aluminium.
constexpr double kSupportStep_k = 1.0, kSupport_k_per_s = 0.1;
// Longer than any machine this is made for.
constexpr double kLongest_mm = 1000;
// Velocity of an axis whose option velocity_mm_s is not given.
constexpr double kFastest_mm_s = 100;
// A length or readback in motion may differ by rounding and by a controller's overshoot.
constexpr double kMotionStep_mm = 0.05;
// 30 deg: no triangulation sensor sees a plate that leans so far away from it.
constexpr double kSteepestPlate_arcsec = 108000;
constexpr double kForceStep_n = 0.02;  // the nearest of an actuator's own weights

double fastest_mm_s(const CellDescription& cell) {
  double fastest = 0;
  for (const auto& device : cell.devices) {
    if (device.axes().empty()) continue;
    const auto given = device.options.find("velocity_mm_s");
    const double velocity =
        given == device.options.end() ? 0 : std::strtod(given->second.c_str(), nullptr);
    fastest = std::max(fastest, velocity > 0 ? velocity : kFastest_mm_s);
  }
  return fastest > 0 ? fastest : kFastest_mm_s;
}

ChannelLimit temperature(double step_k, double k_per_s, const char* what) {
  ChannelLimit limit;
  limit.min = kColdest_degc;
  limit.max = kWarmest_degc;
  limit.max_step = step_k;
  limit.max_per_s = k_per_s;
  limit.latches = true;
  limit.frozen_answers = -1;
  limit.source = what;
  return limit;
}

ChannelLimit of_axis(const CellDescription& cell, const AxisDescription& axis) {
  ChannelLimit limit;
  const double travel_mm = axis.max_mm - axis.min_mm;
  limit.min = axis.min_mm - travel_mm;
  limit.max = axis.max_mm + travel_mm;
  limit.max_step = kMotionStep_mm;
  limit.max_per_s = 10 * fastest_mm_s(cell);
  limit.source = "one travel beyond the soft limits of axis " + axis.device_axis;
  return limit;
}

ChannelLimit of_length(const CellDescription& cell) {
  ChannelLimit limit;
  limit.min = -kLongest_mm;
  limit.max = kLongest_mm;
  limit.max_step = kMotionStep_mm;
  limit.max_per_s = 10 * fastest_mm_s(cell);
  limit.frozen_answers = -1;
  limit.source = "no machine of this kind is longer";
  return limit;
}

ChannelLimit by_unit(std::string_view unit) {
  ChannelLimit limit;
  if (unit == "degC") return temperature(kAirStep_k, kAir_k_per_s, "air in a laboratory");
  if (unit == "pct") {
    limit.min = -150;
    limit.max = 150;
    limit.source = "a share of a range";
  } else if (unit == "hPa") {
    limit.min = 300;
    limit.max = 1100;
    limit.max_step = 5;
    limit.max_per_s = 0.1;
    limit.latches = true;
    limit.source = "air pressure between sea level and 9000 m";
  } else if (unit == "nm") {  // standard deviation of a device's own samples
    limit.min = 0;
    limit.max = 1e9;
    limit.missing = Missing::allowed;
    limit.source = "a standard deviation";
  } else {
    limit.source = "a finite number";
  }
  return limit;
}

// Of a quantity that a voltage stands for: the range in which its sensor is valid. nullopt: another
// channel.
std::optional<ChannelLimit> of_voltages(const CellDescription& cell,
                                        const DeviceDescription& device, std::string_view channel) {
  ChannelLimit limit;
  limit.source = "range of the sensor, min_v .. max_v";
  const auto& sensors = device.voltages.sensors;
  for (const auto& sensor : sensors) {
    if (sensor.channel.name() != channel) continue;
    // A length counts from its zero, which may lie anywhere in the range.
    if (device.length()) return of_length(cell);
    const auto [low, high] = range_of(sensor);
    const double friction = device.voltages.motor ? device.voltages.motor->friction_n : 0;
    limit.min = low - friction;
    limit.max = high + friction;
    // Beyond its range it is a state: a point without force.
    limit.missing = device.role() == DeviceRole::force ? Missing::allowed : Missing::rejected;
    limit.frozen_answers = -1;
    return limit;
  }
  for (const auto& angle : device.angles())
    if (device.voltages.is_plate && angle.channel.name() == channel) {
      limit.min = -kSteepestPlate_arcsec;
      limit.max = kSteepestPlate_arcsec;
      limit.frozen_answers = -1;
      limit.source = "a plate under three sensors";
      return limit;
    }
  return std::nullopt;
}

ChannelLimit default_of(const CellDescription& cell, const DeviceDescription& device,
                        std::string_view channel, std::string_view unit) {
  for (const auto& axis : device.axes())
    if (axis.channel.name() == channel) return of_axis(cell, axis);
  for (const auto& probe : device.probes())
    if (probe.channel.name() == channel)
      return probe.part == "air" ? temperature(kAirStep_k, kAir_k_per_s, "air in a laboratory")
                                 : temperature(kPartStep_k, kPart_k_per_s, "a part of a machine");
  if (!device.voltages.sensors.empty()) {
    if (const auto limit = of_voltages(cell, device, channel)) return *limit;
  }
  if (device.length() && device.length()->channel.name() == channel) return of_length(cell);
  for (const auto& angle : device.angles())
    if (angle.channel.name() == channel) {
      ChannelLimit limit;
      const auto* settings = std::get_if<AngleSettings>(&device.settings);
      const double range_arcsec = (settings ? *settings : AngleSettings{}).range_arcsec;
      limit.min = -range_arcsec;
      limit.max = range_arcsec;
      limit.frozen_answers = -1;
      limit.source = "range of the instrument for angles";
      return limit;
    }
  if (device.force() && device.force()->name() == channel) {
    ChannelLimit limit;
    limit.min = -kForceStep_n;
    limit.max = (cell.load ? cell.load->max_n : 0) + kForceStep_n;
    limit.max_step = kForceStep_n;
    limit.latches = true;
    limit.missing = Missing::allowed;
    limit.source = "[load] max_n";
    return limit;
  }
  if (device.role() == DeviceRole::stabiliser && unit == "degC") {
    auto limit = temperature(kSupportStep_k, kSupport_k_per_s, "a stabilised support");
    limit.is_held = true;
    if (channel.ends_with("_set_degC")) {  // a command may set it anywhere, and it stays there
      limit.max_step = std::numeric_limits<double>::max();
      limit.frozen_answers = 0;
    }
    return limit;
  }
  if (device.role() == DeviceRole::supply) {
    ChannelLimit limit;
    limit.missing = Missing::allowed;  // not every supply knows its charge
    limit.source = "a finite number";
    return limit;
  }
  auto limit = by_unit(unit);
  if (device.role() == DeviceRole::environment && unit == "pct") {
    limit.min = 0;
    limit.max = 100;
    limit.source = "relative humidity";
  }
  return limit;
}

}  // namespace

ChannelLimit limit_of(const CellDescription& cell, const DeviceDescription& device,
                      std::string_view channel) {
  const auto underscore = channel.rfind('_');
  const auto unit =
      underscore == std::string_view::npos ? std::string_view("1") : channel.substr(underscore + 1);
  ChannelLimit limit = default_of(cell, device, channel, unit);
  const auto declared =
      std::ranges::find(cell.plausibility.limits, channel, &ChannelLimitDescription::channel);
  if (declared == cell.plausibility.limits.end()) return limit;
  limit.min = declared->min.value_or(limit.min);
  limit.max = declared->max.value_or(limit.max);
  limit.max_step = declared->max_step.value_or(limit.max_step);
  limit.max_per_s = declared->max_per_s.value_or(limit.max_per_s);
  limit.frozen_answers = declared->frozen_answers.value_or(limit.frozen_answers);
  limit.source = "[[limit]] of the cell file";
  return limit;
}

}  // namespace driftwise::plausibility
