#include "server/core/devices/role_settings.h"

#include <set>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"

namespace driftwise {
namespace {

// Without the robot's id: q1 of ma.q1.
std::string_view local(const Channel& channel) {
  const std::string_view symbol = channel.symbol;
  return symbol.substr(symbol.find('.') + 1);  // the whole of it where there is no dot
}

void read_axis(SettingsReader& reader, AxisDescription& out) {
  reader.channel("channel", out.channel, Need::required);
  reader.text("device_axis", out.device_axis, Need::required);
  reader.number("min_mm", out.min_mm, {}, Need::required);
  reader.number("max_mm", out.max_mm, {}, Need::required);
  reader.number("u_scale_nm", out.u_scale_nm, {.min = 0});
  if (!is_motor_symbol(local(out.channel)) || out.channel.unit != "mm")
    reader.refuse(
        "channel", reasons::kBadChannel,
        "found " + shown(out.channel.name()) + ", expected a motor coordinate such as q1_mm");
  if (!(out.min_mm < out.max_mm))
    reader.refuse("min_mm", reasons::kBadLimits,
                  "found min_mm = " + number_text(out.min_mm) + " and max_mm = " +
                      number_text(out.max_mm) + ", expected min_mm below max_mm");
  else if (out.min_mm > 0 || out.max_mm < 0)
    reader.refuse("min_mm", reasons::kBadLimits,
                  "found limits " + number_text(out.min_mm) + " .. " + number_text(out.max_mm) +
                      " mm, expected 0 between them: every run starts at zero");
  reader.give("channel", out.channel.name());
}

void read_probe(SettingsReader& reader, ProbeDescription& out) {
  reader.channel("channel", out.channel, Need::required);
  reader.integer("input", out.input, 101, 599, Need::required);
  reader.number("r0_ohm", out.r0_ohm, {.min = 0, .above_min = true});
  reader.number("a_per_degc", out.a_per_degc, {.min = 0, .max = 0.1, .above_min = true});
  reader.number("b_per_degc2", out.b_per_degc2, {.min = -1e-3, .max = 0});
  reader.text("place", out.place);
  reader.choice("part", out.part, {"robot", "instrument", "air"}, Need::required);
  reader.number("u_k", out.u_k, {.min = 0});
  if (out.channel.unit != "degC")
    reader.refuse(
        "channel", reasons::kBadChannel,
        "found " + shown(out.channel.name()) + ", expected a temperature in degC such as t07_degC");
  reader.give("channel", out.channel.name());
}

void read_angle(SettingsReader& reader, AngleDescription& out) {
  reader.channel("channel", out.channel, Need::required);
  reader.integer("device_axis", out.device_axis, 1, 2, Need::required);
  reader.integer("sign", out.sign, -1, 1);
  reader.number("u_arcsec", out.u_arcsec, {.min = 0});
  const bool is_rotation = is_pose_symbol(local(out.channel)) && local(out.channel).front() == 'r';
  if (!is_rotation || out.channel.unit != "arcsec")
    reader.refuse("channel", reasons::kBadChannel,
                  "found " + shown(out.channel.name()) +
                      ", expected a rotation: rx_arcsec, ry_arcsec or rz_arcsec");
  if (out.sign == 0) reader.refuse("sign", reasons::kOutOfRange, "found 0, expected 1 or -1");
  reader.give("channel", out.channel.name());
}

}  // namespace

void read_motion_settings(SettingsReader& reader, DeviceDescription& device) {
  MotionSettings settings;
  reader.each("axis", [&](SettingsReader& axis) { read_axis(axis, settings.axes.emplace_back()); });
  device.settings = std::move(settings);
}

void read_length_settings(SettingsReader& reader, DeviceDescription& device) {
  LengthSettings settings;
  reader.channel("length", settings.channel, Need::required);
  reader.number("u_length_nm", settings.u_length_nm, {.min = 0});
  reader.number("u_drift_nm_per_h", settings.u_drift_nm_per_h);
  reader.number("u_drift_nm_per_k", settings.u_drift_nm_per_k);
  reader.channel("drift_channel", settings.drift_channel, Need::optional);
  const bool has_channel = !settings.drift_channel.symbol.empty();
  if (has_channel && settings.drift_channel.unit != "degC")
    reader.refuse("drift_channel", reasons::kBadChannel,
                  "found " + shown(settings.drift_channel.name()) +
                      ", expected a thermometer of the cell such as t04_degC");
  if (has_channel != (settings.u_drift_nm_per_k != 0))
    reader.refuse(has_channel ? "u_drift_nm_per_k" : "drift_channel", reasons::kMissingKey,
                  "found one of u_drift_nm_per_k and drift_channel, expected both: by how much the "
                  "device drifts for each kelvin, and which thermometer says so");
  if (!is_pose_symbol(local(settings.channel)) || settings.channel.unit != "mm")
    reader.refuse("length", reasons::kBadChannel,
                  "found " + shown(settings.channel.name()) +
                      ", expected a pose coordinate in mm such as x_mm");
  reader.give("length", settings.channel.name());
  device.settings = std::move(settings);
}

void read_angle_settings(SettingsReader& reader, DeviceDescription& device) {
  AngleSettings settings;
  std::set<int> device_axes;
  reader.each("angle", [&](SettingsReader& one) {
    auto& angle = settings.angles.emplace_back();
    read_angle(one, angle);
    if (!device_axes.insert(angle.device_axis).second)
      one.refuse("device_axis", reasons::kDuplicateChannel,
                 "found device axis " + std::to_string(angle.device_axis) +
                     ", which another angle of this device has already");
  });
  device.settings = std::move(settings);
}

void read_temperature_settings(SettingsReader& reader, DeviceDescription& device) {
  TemperatureSettings settings;
  std::set<int> inputs;
  reader.each("probe", [&](SettingsReader& one) {
    auto& probe = settings.probes.emplace_back();
    read_probe(one, probe);
    if (!inputs.insert(probe.input).second)
      one.refuse("input", reasons::kDuplicateChannel,
                 "found input " + std::to_string(probe.input) +
                     ", which another probe of this scanner has already");
  });
  device.settings = std::move(settings);
}

void read_stabiliser_settings(SettingsReader& reader, DeviceDescription& device) {
  device.settings = StabiliserSettings{};
  reader.give("id", device.id + "_degC");
}

void read_supply_settings(SettingsReader& reader, DeviceDescription& device) {
  device.settings = SupplySettings{};
  reader.give("id", device.id);
}

void read_load_settings(SettingsReader& reader, DeviceDescription& device) {
  LoadSettings settings;
  reader.channel("channel", settings.force, Need::required);
  if (settings.force.symbol != "force" || settings.force.unit != "N")
    reader.refuse("channel", reasons::kBadChannel,
                  "found " + shown(settings.force.name()) + ", expected force_N");
  reader.give("channel", settings.force.name());
  device.settings = std::move(settings);
}

std::vector<Channel> channels_of_settings(const DeviceDescription& device) {
  std::vector<Channel> out;
  for (const auto& axis : device.axes()) out.push_back(axis.channel);
  if (const auto* length = device.length()) out.push_back(length->channel);
  for (const auto& angle : device.angles()) out.push_back(angle.channel);
  for (const auto& probe : device.probes()) out.push_back(probe.channel);
  for (const auto& quantity : device.quantities()) out.push_back(quantity.channel);
  if (const auto* force = device.force()) out.push_back(*force);
  if (device.role() == DeviceRole::stabiliser) {
    const std::string stem = symbol_from_id(device.id);
    out.push_back({stem, "degC"});
    out.push_back({stem + "_set", "degC"});
    out.push_back({stem + "_power", "pct"});
  }
  return out;
}

}  // namespace driftwise
