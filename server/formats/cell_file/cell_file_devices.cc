#include "server/formats/cell_file/cell_file_devices.h"

#include "server/core/reasons.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

void read_axis(TomlReader&& reader, AxisDescription& out, TakenNames& taken) {
  reader.channel("channel", out.channel, Need::required);
  reader.text("device_axis", out.device_axis, Need::required);
  reader.number("min_mm", out.min_mm, {}, Need::required);
  reader.number("max_mm", out.max_mm, {}, Need::required);
  reader.number("u_scale_nm", out.u_scale_nm, {.min = 0});
  if (!is_motor_symbol(out.channel.symbol) || out.channel.unit != "mm")
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
  taken.channel(reader, "channel", out.channel.name());
  reader.finish();
}

void read_probe(TomlReader&& reader, ProbeDescription& out, TakenNames& taken) {
  reader.channel("channel", out.channel, Need::required);
  reader.integer("input", out.input, 1, 9999, Need::required);
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
  taken.channel(reader, "channel", out.channel.name());
  reader.finish();
}

void read_angle(TomlReader&& reader, AngleDescription& out, TakenNames& taken) {
  reader.channel("channel", out.channel, Need::required);
  reader.integer("device_axis", out.device_axis, 1, 2, Need::required);
  reader.integer("sign", out.sign, -1, 1);
  reader.number("u_arcsec", out.u_arcsec, {.min = 0});
  const bool is_rotation = is_pose_symbol(out.channel.symbol) && out.channel.symbol.front() == 'r';
  if (!is_rotation || out.channel.unit != "arcsec")
    reader.refuse("channel", reasons::kBadChannel,
                  "found " + shown(out.channel.name()) +
                      ", expected a rotation: rx_arcsec, ry_arcsec or rz_arcsec");
  if (out.sign == 0) reader.refuse("sign", reasons::kOutOfRange, "found 0, expected 1 or -1");
  taken.channel(reader, "channel", out.channel.name());
  reader.finish();
}

void read_angles(TomlReader& device, const std::string& place, DeviceDescription& out,
                 TakenNames& taken, TomlProblem& problem) {
  std::set<int> device_axes;
  for (const auto* table : device.tables("angle")) {
    TomlReader reader(*table, place + ", angle " + std::to_string(out.angles.size() + 1), problem);
    TomlReader line = reader;
    auto& angle = out.angles.emplace_back();
    read_angle(std::move(reader), angle, taken);
    if (!device_axes.insert(angle.device_axis).second)
      line.refuse("device_axis", reasons::kDuplicateChannel,
                  "found device axis " + std::to_string(angle.device_axis) +
                      ", which another angle of this autocollimator has already");
  }
  if (out.angles.empty())
    device.refuse("angle", reasons::kMissingKey,
                  "found nothing, expected at least one [[device.angle]]");
}

void read_length(TomlReader& device, DeviceDescription& out, TakenNames& taken) {
  out.length.emplace();
  device.channel("length", *out.length, Need::required);
  device.number("u_length_nm", out.u_length_nm, {.min = 0});
  device.number("u_drift_nm_per_h", out.u_drift_nm_per_h);
  if (!is_pose_symbol(out.length->symbol) || out.length->unit != "mm")
    device.refuse(
        "length", reasons::kBadChannel,
        "found " + shown(out.length->name()) + ", expected a pose coordinate in mm such as x_mm");
  taken.channel(device, "length", out.length->name());
}

void read_force(TomlReader& device, DeviceDescription& out, TakenNames& taken) {
  out.force.emplace();
  device.channel("channel", *out.force, Need::required);
  if (out.force->symbol != "force" || out.force->unit != "N")
    device.refuse("channel", reasons::kBadChannel,
                  "found " + shown(out.force->name()) + ", expected force_N");
  taken.channel(device, "channel", out.force->name());
}

void read_probes(TomlReader& device, const std::string& place, DeviceDescription& out,
                 TakenNames& taken, TomlProblem& problem) {
  std::set<int> inputs;
  for (const auto* table : device.tables("probe")) {
    TomlReader reader(*table, place + ", probe " + std::to_string(out.probes.size() + 1), problem);
    TomlReader line = reader;
    auto& probe = out.probes.emplace_back();
    read_probe(std::move(reader), probe, taken);
    if (!inputs.insert(probe.input).second)
      line.refuse("input", reasons::kDuplicateChannel,
                  "found input " + std::to_string(probe.input) +
                      ", which another probe of this scanner has already");
  }
  if (out.probes.empty())
    device.refuse("probe", reasons::kMissingKey,
                  "found nothing, expected at least one [[device.probe]]");
}

}  // namespace

void TakenNames::channel(TomlReader& reader, const char* key, const std::string& name) {
  if (!channels.insert(name).second)
    reader.refuse(key, reasons::kDuplicateChannel,
                  "found " + shown(name) + ", which another device, axis or probe gives already");
}

void read_device(TomlReader&& reader, const std::string& place, DeviceDescription& out,
                 TakenNames& taken, TomlProblem& problem) {
  reader.text("id", out.id, Need::required);
  if (!taken.ids.insert(out.id).second)
    reader.refuse("id", reasons::kDuplicateId,
                  "found " + shown(out.id) + ", which another device has already");
  reader.choice("kind", out.kind,
                {"pi-gcs", "keithley-2701", "interferometer-adapter", "newport-lds1000",
                 "watlow-ez-zone", "load-actuator"},
                Need::required);
  reader.text("address", out.address, Need::required);
  check_device_address(reader, out.address);
  reader.number("timeout_s", out.timeout_s, {.min = 0, .max = 3600, .above_min = true});
  reader.number("period_s", out.period_s, {.min = 0, .max = 86400});
  reader.number("max_age_s", out.max_age_s, {.min = 0, .above_min = true});
  reader.strings("options", out.options);
  if (problem.any()) return;  // without a kind the rest cannot be judged

  if (out.kind == "pi-gcs") {
    for (const auto* table : reader.tables("axis")) {
      const std::string axis = place + ", axis " + std::to_string(out.axes.size() + 1);
      read_axis(TomlReader(*table, axis, problem), out.axes.emplace_back(), taken);
    }
    if (out.axes.empty())
      reader.refuse("axis", reasons::kMissingKey,
                    "found nothing, expected at least one [[device.axis]]");
  } else if (out.kind == "keithley-2701") {
    read_probes(reader, place, out, taken, problem);
  } else if (out.kind == "interferometer-adapter") {
    read_length(reader, out, taken);
  } else if (out.kind == "newport-lds1000") {
    read_angles(reader, place, out, taken, problem);
  } else if (out.kind == "load-actuator") {
    read_force(reader, out, taken);
  } else {
    taken.channel(reader, "id",
                  out.id + "_degC");  // a stabiliser gives <id>_degC, <id>_set_degC, <id>_power_pct
  }
  reader.finish();
}

}  // namespace driftwise::formats
