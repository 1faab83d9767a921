#include "server/formats/cell_file.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "server/formats/text.h"
#include "server/formats/toml_reader.h"

namespace driftwise::formats {
namespace {

struct HostPort {
  std::string_view host, port;
};

HostPort split_address(std::string_view address) {
  const auto colon = address.rfind(':');
  if (colon == std::string_view::npos) return {address, {}};
  return {address.substr(0, colon), address.substr(colon + 1)};
}

bool is_port(std::string_view text, int lowest) {
  int port = -1;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), port);
  return code == std::errc{} && end == text.data() + text.size() && port >= lowest && port <= 65535;
}

// host:port with a number of a port, or the path of a serial line.
void check_device_address(TomlReader& reader, const std::string& address) {
  if (address.empty() || address.front() == '/') return;
  const auto [host, port] = split_address(address);
  const bool open_ipv6 =
      host.find(':') != std::string_view::npos && !(host.starts_with('[') && host.ends_with(']'));
  if (host.empty() || open_ipv6 || !is_port(port, 1))
    reader.refuse("address", "BAD_ADDRESS",
                  "found " + shown(address) +
                      ", expected host:port such as 127.0.0.1:50000 with a port from 1 to 65535, "
                      "or a serial line such as /dev/ttyUSB0");
}

void check_listen(TomlReader& reader, const char* key, const std::string& address) {
  if (address.empty()) return;
  if (!is_port(split_address(address).port, 0))
    return reader.refuse(key, "BAD_ADDRESS",
                         "found " + shown(address) +
                             ", expected host:port such as 127.0.0.1:50051 (port 0: any free one)");
  DeviceDescription asked;
  asked.address = address;
  if (!asked.on_loopback())
    reader.refuse(key, "LISTEN_NOT_LOOPBACK",
                  "found " + shown(address) +
                      ", expected an address on loopback (127.0.0.1, localhost or [::1]): nothing "
                      "else may reach the daemon until TLS and roles are configured");
}

std::string beside(const std::string& file, const std::string& cell_path) {
  if (file.empty()) return file;
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::absolute(fs::path(cell_path), ignored).parent_path();
  return (folder / file).lexically_normal().string();  // an absolute file replaces the folder
}

void read_cell(TomlReader&& cell, CellDescription& out) {
  cell.text("name", out.name, Need::required);
  cell.text("database", out.database, Need::required);
  cell.text("listen", out.listen);
  cell.text("target_line", out.target_line);
  cell.text("http", out.http);
  check_listen(cell, "listen", out.listen);
  check_listen(cell, "target_line", out.target_line);
  check_listen(cell, "http", out.http);
  cell.finish();
}

void read_clock(TomlReader&& clock, ClockDescription& out) {
  clock.time("epoch", out.epoch);
  clock.number("speed", out.speed, {.min = 0, .max = 1e5, .above_min = true});
  clock.text("file", out.file);
  clock.finish();
}

void read_run(TomlReader&& run, RunRules& out) {
  constexpr Range kPositive{.min = 0, .above_min = true};
  constexpr Range kNotNegative{.min = 0};
  run.integer("readings_per_point", out.readings_per_point, 1, 1000);
  run.number("max_spread_nm", out.max_spread_nm, kPositive);
  run.integer("max_rereads", out.max_rereads, 0, 100);
  run.integer("max_reapproaches", out.max_reapproaches, 0, 100);
  run.integer("max_requeues", out.max_requeues, 0, 100);
  run.number("reapproach_mm", out.reapproach_mm, kNotNegative);
  run.number("settle_s", out.settle_s, kNotNegative);
  run.number("in_position_nm", out.in_position_nm, kPositive);
  run.number("quiet_nm", out.quiet_nm, kPositive);
  run.number("move_timeout_s", out.move_timeout_s, kPositive);
  run.number("max_temperature_age_s", out.max_temperature_age_s, kPositive);
  run.finish();
}

void read_checks(TomlReader&& checks, StartChecks& out) {
  checks.number("stabiliser_band_k", out.stabiliser_band_k, {.min = 0, .above_min = true});
  checks.number("stabiliser_wait_s", out.stabiliser_wait_s, {.min = 0});
  checks.number("max_drift_nm_per_min", out.max_drift_nm_per_min, {.min = 0, .above_min = true});
  checks.number("drift_window_s", out.drift_window_s, {.min = 0, .above_min = true});
  checks.finish();
}

void read_serving(TomlReader&& serving, ServingRules& out) {
  serving.number("rebuild_period_s", out.rebuild_period_s, {.min = 0.1, .max = 3600});
  serving.truth("refuse_stale", out.refuse_stale);
  serving.truth("refuse_outside_domain", out.refuse_outside_domain);
  serving.number("max_age_s", out.max_age_s, {.min = 0, .above_min = true});
  serving.finish();
}

// Names that may stand once in a cell.
struct Taken {
  std::set<std::string> ids, channels;

  void channel(TomlReader& reader, const char* key, const std::string& name) {
    if (!channels.insert(name).second)
      reader.refuse(key, "DUPLICATE_CHANNEL",
                    "found " + shown(name) + ", which another device, axis or probe gives already");
  }
};

void read_axis(TomlReader&& reader, AxisDescription& out, Taken& taken) {
  reader.channel("channel", out.channel, Need::required);
  reader.text("device_axis", out.device_axis, Need::required);
  reader.number("min_mm", out.min_mm, {}, Need::required);
  reader.number("max_mm", out.max_mm, {}, Need::required);
  reader.number("u_scale_nm", out.u_scale_nm, {.min = 0});
  if (!is_motor_symbol(out.channel.symbol) || out.channel.unit != "mm")
    reader.refuse(
        "channel", "BAD_CHANNEL",
        "found " + shown(out.channel.name()) + ", expected a motor coordinate such as q1_mm");
  if (!(out.min_mm < out.max_mm))
    reader.refuse("min_mm", "BAD_LIMITS",
                  "found min_mm = " + number_text(out.min_mm) + " and max_mm = " +
                      number_text(out.max_mm) + ", expected min_mm below max_mm");
  else if (out.min_mm > 0 || out.max_mm < 0)
    reader.refuse("min_mm", "BAD_LIMITS",
                  "found limits " + number_text(out.min_mm) + " .. " + number_text(out.max_mm) +
                      " mm, expected 0 between them: every run starts at zero");
  taken.channel(reader, "channel", out.channel.name());
  reader.finish();
}

void read_probe(TomlReader&& reader, ProbeDescription& out, Taken& taken) {
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
        "channel", "BAD_CHANNEL",
        "found " + shown(out.channel.name()) + ", expected a temperature in degC such as t07_degC");
  taken.channel(reader, "channel", out.channel.name());
  reader.finish();
}

void read_probes(TomlReader& device, const std::string& place, DeviceDescription& out, Taken& taken,
                 TomlProblem& problem) {
  std::set<int> inputs;
  for (const auto* table : device.tables("probe")) {
    TomlReader reader(*table, place + ", probe " + std::to_string(out.probes.size() + 1), problem);
    TomlReader line = reader;
    auto& probe = out.probes.emplace_back();
    read_probe(std::move(reader), probe, taken);
    if (!inputs.insert(probe.input).second)
      line.refuse("input", "DUPLICATE_CHANNEL",
                  "found input " + std::to_string(probe.input) +
                      ", which another probe of this scanner has already");
  }
  if (out.probes.empty())
    device.refuse("probe", "MISSING_KEY", "found nothing, expected at least one [[device.probe]]");
}

void read_device(TomlReader&& reader, const std::string& place, DeviceDescription& out,
                 Taken& taken, TomlProblem& problem) {
  reader.text("id", out.id, Need::required);
  if (!taken.ids.insert(out.id).second)
    reader.refuse("id", "DUPLICATE_ID",
                  "found " + shown(out.id) + ", which another device has already");
  reader.choice("kind", out.kind,
                {"pi-gcs", "keithley-2701", "interferometer-adapter", "watlow-ez-zone"},
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
      reader.refuse("axis", "MISSING_KEY", "found nothing, expected at least one [[device.axis]]");
  } else if (out.kind == "keithley-2701") {
    read_probes(reader, place, out, taken, problem);
  } else if (out.kind == "interferometer-adapter") {
    out.length.emplace();
    reader.channel("length", *out.length, Need::required);
    reader.number("u_length_nm", out.u_length_nm, {.min = 0});
    if (!is_pose_symbol(out.length->symbol) || out.length->unit != "mm")
      reader.refuse(
          "length", "BAD_CHANNEL",
          "found " + shown(out.length->name()) + ", expected a pose coordinate in mm such as x_mm");
    taken.channel(reader, "length", out.length->name());
  } else {
    taken.channel(reader, "id",
                  out.id + "_degC");  // a stabiliser gives <id>_degC, <id>_set_degC, <id>_power_pct
  }
  reader.finish();
}

void check_speed(TomlReader& clock, const CellDescription& cell) {
  if (cell.clock.speed == 1.0) return;
  for (const auto& device : cell.devices)
    if (!device.on_loopback())
      return clock.refuse(
          "speed", "SPEED_NEEDS_LOOPBACK",
          "found " + number_text(cell.clock.speed) + " with device " + shown(device.id) + " at " +
              shown(device.address) +
              ", expected 1: only a simulated cell on loopback has another time than the world's",
          ErrorCode::failed_precondition);
}

void read_file(const toml::table& root, CellDescription& out, TomlProblem& problem) {
  const toml::table none;
  TomlReader top(root, "", problem);
  const auto section = [&](const char* key) {
    const auto* table = top.table(key);
    return TomlReader(table ? *table : none, key, problem);
  };
  TomlReader cell = section("cell");
  if (!root.contains("cell"))
    top.refuse("cell", "MISSING_KEY",
               "found no [cell] section, expected one with name and database");
  read_cell(std::move(cell), out);
  TomlReader clock = section("clock");
  TomlReader speed = clock;
  read_clock(std::move(clock), out.clock);
  read_run(section("run"), out.run);
  read_checks(section("checks"), out.checks);
  read_serving(section("serving"), out.serving);
  Taken taken;
  for (const auto* table : top.tables("device")) {
    const std::string place = "device " + std::to_string(out.devices.size() + 1);
    read_device(TomlReader(*table, place, problem), place, out.devices.emplace_back(), taken,
                problem);
  }
  if (out.devices.empty())
    top.refuse("device", "MISSING_KEY", "found no [[device]], expected at least one");
  top.finish();
  check_speed(speed, out);
}

}  // namespace

Result<CellDescription> parse_cell_file(std::string_view text, const std::string& path) {
  TomlProblem problem{.file_name = path, .first = {}};
  CellDescription cell;
  try {
    read_file(toml::parse(text, path), cell, problem);
  } catch (const toml::parse_error& error) {
    return fail(ErrorCode::invalid_argument, "TOML_SYNTAX",
                at_line(path, error.source().begin.line) + "column " +
                    std::to_string(error.source().begin.column) + ": " +
                    std::string(error.description()));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  cell.database = beside(cell.database, path);
  cell.clock.file = beside(cell.clock.file, path);
  cell.text = text;
  cell.hash = content_hash(text);
  return cell;
}

Result<CellDescription> read_cell_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return fail(
        ErrorCode::not_found, "NO_FILE",
        "cannot open the cell file " + shown(path) + ": check the path and its permissions");
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad())
    return fail(ErrorCode::not_found, "NO_FILE", "cannot read the cell file " + shown(path));
  return parse_cell_file(text, path);
}

}  // namespace driftwise::formats
