#include "server/formats/cell_file/cell_parts.h"

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <set>
#include <sstream>
#include <utility>

#include "server/effects/term_order.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/cell_file/cell_file_closure.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

std::string text_of(double value) { return effects::number_text(value); }
std::string text_of(bool value) { return value ? "true" : "false"; }
std::string text_of(AfterAway value) { return value == AfterAway::wait ? "wait" : "go-on"; }
std::string text_of(int value) { return std::to_string(value); }
template <std::size_t N>
std::string text_of(const std::array<double, N>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + text_of(value);
  return "[" + text + "]";
}

std::vector<std::string> symbols_of_lengths(const CellDescription& cell) {
  std::vector<std::string> symbols;
  for (const auto& channel : cell.length_channels()) symbols.push_back(channel.symbol);
  return symbols;
}

// Rotations turn corrected lengths too.
std::vector<std::string> with_lengths(const CellDescription& cell, const std::string& symbol) {
  std::vector<std::string> symbols = {symbol};
  if (cell.correction)
    for (auto& length : symbols_of_lengths(cell)) symbols.push_back(std::move(length));
  return symbols;
}

}  // namespace

std::vector<std::string> symbols_of(const CellDescription& cell, const DeviceDescription& device) {
  std::vector<std::string> symbols;
  const bool is_length = device.role() == DeviceRole::length;
  if (is_length) symbols = {"air", "pressure", "humidity"};  // its length depends on the air
  const bool is_angle = device.role() == DeviceRole::angle;
  for (const auto& channel : device.channels)
    for (auto& symbol :
         is_angle ? with_lengths(cell, channel.symbol) : std::vector<std::string>{channel.symbol})
      symbols.push_back(std::move(symbol));
  return symbols;
}

namespace {

void add_voltages(const DeviceDescription& device, const std::vector<std::string>& affects,
                  CellParts& parts) {
  for (const auto& sensor : device.voltages.sensors)
    parts["sensor " + device.id + " " + text_of(sensor.input)] = {
        {{"device", device.id},
         {"channel", sensor.channel.symbol.empty() ? "" : sensor.channel.name()},
         {"curve", sensor.curve == SensorCurve::arcsine ? "arcsine" : "linear"},
         {"slope", text_of(sensor.slope)},
         {"zero_v", text_of(sensor.zero_v)},
         {"min_v", text_of(sensor.min_v)},
         {"max_v", text_of(sensor.max_v)},
         {"u", text_of(sensor.u)},
         {"x_mm", text_of(sensor.x_mm)},
         {"y_mm", text_of(sensor.y_mm)}},
        affects};
  if (const auto& motor = device.voltages.motor)
    parts["motor force " + device.id] = {{{"axis", motor->axis.name()},
                                          {"friction_n", text_of(motor->friction_n)},
                                          {"u_friction_n", text_of(motor->u_friction_n)},
                                          {"travel_mm", text_of(motor->travel_mm)}},
                                         affects};
}

void add_device(const CellDescription& cell, const DeviceDescription& device, CellParts& parts) {
  auto& part = parts["device " + device.id];
  part.affects = symbols_of(cell, device);
  const bool serial_line = device.address.starts_with("/");
  const auto address = split_address(device.address);
  part.values = {{"kind", device.kind},
                 {"address", serial_line ? "serial line" : std::string(address.host)},
                 {"port", serial_line ? device.address : std::string(address.port)},
                 {"timeout_s", text_of(device.timeout_s)},
                 {"period_s", text_of(device.period_s)},
                 {"max_age_s", text_of(device.max_age_s)}};
  if (const auto* length = device.length()) {
    part.values["length"] = length->channel.name();
    part.values["u_length_nm"] = text_of(length->u_length_nm);
    part.values["u_drift_nm_per_h"] = text_of(length->u_drift_nm_per_h);
    part.values["u_drift_nm_per_k"] = text_of(length->u_drift_nm_per_k);
    if (!length->drift_channel.symbol.empty())
      part.values["drift_channel"] = length->drift_channel.name();
  }
  if (const auto* force = device.force()) part.values["channel"] = force->name();
  add_voltages(device, part.affects, parts);
  for (const auto& [name, value] : device.options) part.values["options." + name] = value;
  for (const auto& axis : device.axes())
    parts["axis " + axis.channel.name()] = {{{"device", device.id},
                                             {"device_axis", axis.device_axis},
                                             {"min_mm", text_of(axis.min_mm)},
                                             {"max_mm", text_of(axis.max_mm)},
                                             {"u_scale_nm", text_of(axis.u_scale_nm)}},
                                            {axis.channel.symbol}};
  for (const auto& probe : device.probes())
    parts["probe " + probe.channel.name()] = {{{"device", device.id},
                                               {"input", text_of(probe.input)},
                                               {"part", probe.part},
                                               {"place", probe.place},
                                               {"r0_ohm", text_of(probe.r0_ohm)},
                                               {"a_per_degc", text_of(probe.a_per_degc)},
                                               {"b_per_degc2", text_of(probe.b_per_degc2)},
                                               {"u_k", text_of(probe.u_k)}},
                                              {probe.channel.symbol}};
  for (const auto& angle : device.angles())
    parts["angle " + angle.channel.name()] = {{{"device", device.id},
                                               {"device_axis", text_of(angle.device_axis)},
                                               {"sign", text_of(angle.sign)},
                                               {"u_arcsec", text_of(angle.u_arcsec)}},
                                              with_lengths(cell, angle.channel.symbol)};
}

void add_kinematics(const CellDescription& cell, CellParts& parts) {
  const auto& robot = *cell.kinematics;
  std::vector<std::string> all = symbols_of_lengths(cell);
  for (const auto& channel : cell.motor_channels()) all.push_back(channel.symbol);
  const auto& frame = robot.frame;
  auto& part = parts["kinematics"];
  part.affects = all;
  part.values = {
      {"kind", robot.kind},
      {"carriages_above", text_of(robot.carriages_above)},
      {"tool_mm", text_of(std::array{robot.tool_x_mm, robot.tool_y_mm, robot.tool_z_mm})},
      {"frame_mm", text_of(std::array{frame.x_mm, frame.y_mm, frame.z_mm})},
      {"frame_deg", text_of(std::array{frame.rx_deg, frame.ry_deg, frame.rz_deg})}};
  if (robot.kind == "serial-arm") {
    part.values["gravity"] = text_of(robot.gravity);
    part.values["tool_mass_kg"] = text_of(robot.tool_mass_kg);
  }
  std::string hold;
  for (const auto& one : robot.hold) hold += (hold.empty() ? "" : ", ") + one;
  part.values["hold"] = hold;
  for (const auto& branch : robot.branches)
    parts["kinematics branch " + branch.motor.name()] = {
        {{"azimuth_deg", text_of(branch.azimuth_deg)},
         {"radius_mm", text_of(branch.radius_mm)},
         {"length_mm", text_of(branch.length_mm)},
         {"offset_mm", text_of(branch.offset_mm)},
         {"tilt_radial_deg", text_of(branch.tilt_radial_deg)},
         {"tilt_tangential_deg", text_of(branch.tilt_tangential_deg)},
         {"scale_ppm", text_of(branch.scale_ppm)}},
        all};
  for (const auto& link : robot.links) {
    const auto& errors = link.errors;
    parts["kinematics link " + link.motor.name()] = {
        {{"theta_deg", text_of(link.theta_deg)},
         {"d_mm", text_of(link.d_mm)},
         {"a_mm", text_of(link.a_mm)},
         {"alpha_deg", text_of(link.alpha_deg)},
         {"beta_deg", text_of(link.beta_deg)},
         {"mass_kg", text_of(link.mass_kg)},
         {"mass_centre_mm", text_of(link.mass_centre_mm)},
         {"sag_urad_per_m", text_of(errors.sag_urad_per_m)},
         {"sag_urad_per_newton_m", text_of(errors.sag_urad_per_newton_m)},
         {"play_arcsec", text_of(errors.play_arcsec)},
         {"gear_arcsec", text_of(std::array{errors.gear_cos1_arcsec, errors.gear_sin1_arcsec,
                                            errors.gear_cos2_arcsec, errors.gear_sin2_arcsec})},
         {"drift", errors.drift_channel.symbol.empty()
                       ? ""
                       : errors.drift_channel.name() + " " + text_of(errors.drift_arcsec_per_k) +
                             " arcsec/K from " + text_of(errors.drift_from_degC) + " degC"},
         {"limits_deg", text_of(std::array{link.min_deg, link.max_deg})}},
        all};
  }
  for (const auto& axis : robot.axes)
    parts["kinematics axis " + axis.motor.name()] = {{{"pose", axis.pose.name()},
                                                      {"offset_mm", text_of(axis.offset_mm)},
                                                      {"scale_ppm", text_of(axis.scale_ppm)}},
                                                     all};
}

void add_correction(const CellDescription& cell, CellParts& parts) {
  parts["correction"] = {{{"cosine", text_of(cell.correction->cosine)}}, symbols_of_lengths(cell)};
  for (const auto& beam : cell.correction->beams)
    parts["beam " + beam.length.name()] = {
        {{"offset_mm", text_of(beam.offset_mm)},
         {"offset_per_mm", text_of(beam.offset_per_mm)},
         {"u_offset_mm", text_of(beam.u_offset_mm)},
         {"direction_arcsec", text_of(beam.direction_arcsec)},
         {"u_direction_arcsec", text_of(beam.u_direction_arcsec)},
         {"u_flatness_nm", text_of(beam.u_flatness_nm)}},
        {beam.length.symbol}};
}

void add_rules(const CellDescription& cell, CellParts& parts) {
  const auto& run = cell.run;
  parts["run"].values = {{"readings_per_point", text_of(run.readings_per_point)},
                         {"max_spread_nm", text_of(run.max_spread_nm)},
                         {"max_spread_arcsec", text_of(run.max_spread_arcsec)},
                         {"max_rereads", text_of(run.max_rereads)},
                         {"max_reapproaches", text_of(run.max_reapproaches)},
                         {"max_requeues", text_of(run.max_requeues)},
                         {"reapproach_mm", text_of(run.reapproach_mm)},
                         {"settle_s", text_of(run.settle_s)},
                         {"in_position_nm", text_of(run.in_position_nm)},
                         {"quiet_nm", text_of(run.quiet_nm)},
                         {"move_timeout_s", text_of(run.move_timeout_s)},
                         {"max_temperature_age_s", text_of(run.max_temperature_age_s)},
                         {"max_given_up_share", text_of(run.max_given_up_share)},
                         {"park", text_of(run.park)},
                         {"after_restart", text_of(cell.restart.after_restart)},
                         {"after_power_loss", text_of(cell.restart.after_power_loss)}};
  parts["checks"].values = {{"stabiliser_band_k", text_of(cell.checks.stabiliser_band_k)},
                            {"stabiliser_wait_s", text_of(cell.checks.stabiliser_wait_s)},
                            {"hold_on_stabilisers", text_of(cell.checks.hold_on_stabilisers)},
                            {"max_drift_nm_per_min", text_of(cell.checks.max_drift_nm_per_min)},
                            {"drift_window_s", text_of(cell.checks.drift_window_s)}};
  const auto& limits = cell.plausibility;
  parts["plausibility"].values = {
      {"geometry_um", text_of(limits.geometry_um)},
      {"geometry_pct", text_of(limits.geometry_pct)},
      {"closure_nm", text_of(limits.closure_nm)},
      {"closure_nm_per_min",
       text_of(limits.closure_nm_per_min.value_or(cell.checks.max_drift_nm_per_min))},
      {"closure_arcsec", text_of(limits.closure_arcsec)},
      {"together_k", text_of(limits.together_k)}};
  parts["serving"].values = {{"rebuild_period_s", text_of(cell.serving.rebuild_period_s)},
                             {"refuse_stale", text_of(cell.serving.refuse_stale)},
                             {"refuse_outside_domain", text_of(cell.serving.refuse_outside_domain)},
                             {"refuse_outside_limits", text_of(cell.serving.refuse_outside_limits)},
                             {"max_age_s", text_of(cell.serving.max_age_s)}};
}

void add_closure(const CellDescription& cell, CellParts& parts) {
  const auto rules = closure_rules_of(cell);
  parts["closure"].values = {
      {"unexplained", rules.unexplained == UnexplainedClosure::mark     ? "mark"
                      : rules.unexplained == UnexplainedClosure::repeat ? "repeat"
                                                                        : "new-datum"},
      {"repeats", text_of(rules.repeats)}};
  for (const auto& limit : rules.limits) {
    auto& part = parts["closure_limit " + limit.channel];
    part.affects = {limit.channel.substr(0, limit.channel.rfind('_'))};
    part.values[is_angle(limit.channel.substr(limit.channel.rfind('_') + 1)) ? "limit_arcsec"
                                                                             : "limit_nm"] =
        text_of(limit.limit);
  }
}

// Declared limits of single channels; what is not declared has the default of its kind.
void add_limits(const CellDescription& cell, CellParts& parts) {
  for (const auto& limit : cell.plausibility.limits) {
    auto& part = parts["limit " + limit.channel];
    part.affects = {limit.channel.substr(0, limit.channel.rfind('_'))};
    const auto add = [&part](const char* key, const std::optional<double>& value) {
      if (value) part.values[key] = text_of(*value);
    };
    add("min", limit.min);
    add("max", limit.max);
    add("max_step", limit.max_step);
    add("max_per_s", limit.max_per_s);
    if (limit.frozen_answers) part.values["frozen_answers"] = text_of(*limit.frozen_answers);
  }
}

void add_setups(const CellDescription& cell, CellParts& parts) {
  for (const auto& setup : cell.setups) {
    auto& part = parts["setup " + setup.name];
    part.values["description"] = setup.description;
    for (const auto& coordinate : setup.coordinates) {
      part.affects.push_back(coordinate.channel.symbol);
      part.values[coordinate.channel.name()] =
          coordinate.device + ", scale " + text_of(coordinate.scale) + ", offset " +
          text_of(coordinate.offset) + (coordinate.min ? ", min " + text_of(*coordinate.min) : "") +
          (coordinate.max ? ", max " + text_of(*coordinate.max) : "");
    }
    for (const auto& one : setup.confirmations)
      part.values["confirmation " + one.channel.name()] =
          one.device + ", scale " + text_of(one.scale) + ", offset " + text_of(one.offset) +
          ", limit " + text_of(one.limit);
  }
}

// Everything that a description holds, defaults included.
CellParts parts_of(const CellDescription& cell) {
  CellParts parts;
  parts["cell"].values = {{"name", cell.name},
                          {"listen", cell.listen},
                          {"target_line", cell.target_line},
                          {"http", cell.http}};
  parts["clock"].values = {
      {"epoch", cell.clock.epoch.utc_ns == 0 ? "" : to_iso8601(cell.clock.epoch)},
      {"speed", text_of(cell.clock.speed)}};
  add_rules(cell, parts);
  add_closure(cell, parts);
  add_limits(cell, parts);
  for (const auto& device : cell.devices) add_device(cell, device, parts);
  add_setups(cell, parts);
  if (cell.load)
    parts["load"] = {{{"max_n", text_of(cell.load->max_n)},
                      {"u_n", text_of(cell.load->u_n)},
                      {"gravity_m_s2", text_of(cell.load->gravity_m_s2)}},
                     {"force"}};
  if (cell.correction) add_correction(cell, parts);
  if (cell.kinematics) add_kinematics(cell, parts);
  return parts;
}

// Keys of the text that the description's list does not know: those of sections and keys that were
// added later. Compared as TOML, without defaults.
//
// A place in the text. name: the whole path with the name of each element of a list, so that no two
// places have the same one: "keep_out tips axis ma.q1_mm". kind: the path without the names.
struct TextPlace {
  std::string name, kind;
};
using KnownKeys = std::set<std::pair<std::string, std::string>>;  // (kind of place, key)
void add_unknown(const toml::node& node, const TextPlace& at, const std::string& key,
                 const KnownKeys& known, CellParts& parts);

std::string value_text(const toml::node& node) {
  if (const auto number = node.value<double>();
      number && (node.is_integer() || node.is_floating_point()))
    return text_of(*number);
  if (const auto truth = node.value<bool>()) return text_of(*truth);
  if (const auto* text = node.as_string()) return text->get();
  std::ostringstream out;
  if (const auto* array = node.as_array()) {
    out << '[';
    for (std::size_t i = 0; i < array->size(); ++i)
      out << (i ? ", " : "") << value_text((*array)[i]);
    out << ']';
  } else if (const auto* table = node.as_table()) {
    out << '{';
    bool first = true;
    for (const auto& [name, value] : *table) {  // in the order of the names
      out << (first ? "" : ", ") << name.str() << " = " << value_text(value);
      first = false;
    }
    out << '}';
  } else {
    node.visit([&out](const auto& value) { out << value; });
  }
  return out.str();
}

// Name of an element of a list of tables within it: "laser-x"; without one, its place in the list.
std::string name_of(const toml::table& table, std::size_t index) {
  for (const char* name : {"id", "channel", "length", "motor", "name", "number", "input"}) {
    if (const auto text = table[name].value<std::string>()) return *text;
    if (const auto number = table[name].value<std::int64_t>()) return std::to_string(*number);
  }
  return std::to_string(index + 1);
}

void add_table(const toml::table& table, const TextPlace& at, const KnownKeys& known,
               CellParts& parts) {
  for (const auto& [key, node] : table) add_unknown(node, at, std::string(key.str()), known, parts);
}

void add_unknown(const toml::node& node, const TextPlace& at, const std::string& key,
                 const KnownKeys& known, CellParts& parts) {
  if (known.contains({at.kind, key}) || known.contains({at.kind, "*"})) return;
  const auto under = [&key](const std::string& path) {
    return path.empty() ? key : path + " " + key;
  };
  const std::string kind = under(at.kind), name = under(at.name);
  if (const auto* array = node.as_array();
      array && !array->empty() && array->is_array_of_tables()) {
    // What the description's list has a part for goes with that part: "probe t07_degC".
    const auto listed = known.lower_bound({kind, ""});
    const bool has_part = listed != known.end() && listed->first == kind;
    for (std::size_t i = 0; i < array->size(); ++i) {
      const auto& table = *(*array)[i].as_table();
      add_table(table, {(has_part ? key : name) + " " + name_of(table, i), kind}, known, parts);
    }
    return;
  }
  if (const auto* table = node.as_table()) return add_table(*table, {name, kind}, known, parts);
  parts[at.name.empty() ? key : at.name].values[key] = value_text(node);
}

// (kind of place, key) of everything that parts_of() speaks of, under the names of the text.
KnownKeys known_keys() {
  KnownKeys known;
  const auto add = [&known](const char* kind, std::initializer_list<const char*> keys) {
    for (const char* key : keys) known.emplace(kind, key);
  };
  add("cell", {"name", "database", "listen", "target_line", "http"});
  add("clock", {"epoch", "speed", "file"});
  add("run", {"readings_per_point", "max_spread_nm", "max_spread_arcsec", "max_rereads",
              "max_reapproaches", "max_requeues", "reapproach_mm", "settle_s", "in_position_nm",
              "quiet_nm", "move_timeout_s", "max_temperature_age_s", "max_given_up_share", "park",
              "after_restart", "after_power_loss"});
  add("checks", {"stabiliser_band_k", "stabiliser_wait_s", "hold_on_stabilisers",
                 "max_drift_nm_per_min", "drift_window_s"});
  add("plausibility", {"geometry_um", "geometry_pct", "closure_nm", "closure_nm_per_min",
                       "closure_arcsec", "together_k"});
  add("closure", {"unexplained", "repeats"});
  add("closure_limit", {"*"});
  add("limit", {"*"});
  add("serving", {"rebuild_period_s", "refuse_stale", "refuse_outside_domain",
                  "refuse_outside_limits", "max_age_s"});
  add("device",
      {"id", "kind", "address", "timeout_s", "period_s", "max_age_s", "options", "length",
       "u_length_nm", "u_drift_nm_per_h", "u_drift_nm_per_k", "drift_channel", "channel"});
  add("device axis", {"channel", "device_axis", "min_mm", "max_mm", "u_scale_nm"});
  add("device probe",
      {"channel", "input", "part", "place", "r0_ohm", "a_per_degc", "b_per_degc2", "u_k"});
  add("device angle", {"channel", "device_axis", "sign", "u_arcsec"});
  add("load", {"max_n", "u_n", "gravity_m_s2"});
  add("correction", {"cosine"});
  add("correction beam", {"length", "offset_mm", "offset_per_mm", "u_offset_mm", "direction_arcsec",
                          "u_direction_arcsec", "u_flatness_nm"});
  add("kinematics", {"*"});
  add("setup", {"*"});
  return known;
}

// Data of a robot, its tool above all, are part of what its motor coordinates mean. A cell's
// only robot has an id in the text alone.
void add_robots(const CellDescription& cell, CellParts& parts) {
  for (auto& [place, part] : parts)
    for (const auto& robot : cell.robots)
      if (place.starts_with("robot ") &&
          (robot.id.empty() || (place + " ").starts_with("robot " + robot.id + " ")))
        for (const auto& axis : robot.axes) part.affects.push_back(axis.symbol);
}

}  // namespace

CellParts cell_parts(const CellDescription& cell, std::string_view text) {
  CellParts parts = parts_of(cell);
  try {
    CellParts further;
    add_table(parse_toml(text), {}, known_keys(), further);
    for (auto& [place, part] : further)
      for (auto& [key, value] : part.values) parts[place].values.emplace(key, value);
    add_robots(cell, parts);
  } catch (const toml::parse_error&) {  // a description that was not made from a text
  }
  return parts;
}

}  // namespace driftwise::formats
