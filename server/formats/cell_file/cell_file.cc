#include "server/formats/cell_file/cell_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "server/core/reasons.h"
#include "server/formats/cell_file/cell_file_access.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/cell_file/cell_file_certificates.h"
#include "server/formats/cell_file/cell_file_closure.h"
#include "server/formats/cell_file/cell_file_correction.h"
#include "server/formats/cell_file/cell_file_devices.h"
#include "server/formats/cell_file/cell_file_holds.h"
#include "server/formats/cell_file/cell_file_keep_outs.h"
#include "server/formats/cell_file/cell_file_limits.h"
#include "server/formats/cell_file/cell_file_notify.h"
#include "server/formats/cell_file/cell_file_robots.h"
#include "server/formats/cell_file/cell_file_setups.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

void check_listen(TomlReader& reader, const char* key, const std::string& address) {
  if (address.empty()) return;
  if (has_blank(address) || !is_port(split_address(address).port, 0))
    return reader.refuse(key, reasons::kBadAddress,
                         "found " + shown(address) +
                             ", expected host:port such as 127.0.0.1:50051 (port 0: any free one)");
  DeviceDescription asked;  // the one rule of what loopback means
  asked.address = address;
  if (!asked.on_loopback())
    reader.refuse(
        key, reasons::kListenNotLoopback,
        "found " + shown(address) +
            ", expected an address on loopback (127.0.0.1, localhost or [::1]): a door that "
            "others can reach needs TLS and stands under " +
            shown(key) + " of [access] (docs/access.md)");
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

void read_after(TomlReader& run, const char* key, AfterAway& out) {
  std::string found = out == AfterAway::wait ? "wait" : "go-on";
  run.choice(key, found, {"go-on", "wait"}, Need::optional);
  out = found == "wait" ? AfterAway::wait : AfterAway::go_on;
}

void read_run(TomlReader&& run, RunRules& out, RestartRules& restart) {
  constexpr Range kPositive{.min = 0, .above_min = true};
  constexpr Range kNotNegative{.min = 0};
  run.integer("readings_per_point", out.readings_per_point, 1, 1000);
  run.number("max_spread_nm", out.max_spread_nm, kPositive);
  run.number("max_spread_arcsec", out.max_spread_arcsec, kPositive);
  run.integer("max_rereads", out.max_rereads, 0, 100);
  run.integer("max_reapproaches", out.max_reapproaches, 0, 100);
  run.integer("max_requeues", out.max_requeues, 0, 100);
  run.number("reapproach_mm", out.reapproach_mm, kNotNegative);
  run.number("settle_s", out.settle_s, kNotNegative);
  run.number("in_position_nm", out.in_position_nm, kPositive);
  run.number("quiet_nm", out.quiet_nm, kPositive);
  run.number("move_timeout_s", out.move_timeout_s, kPositive);
  run.number("max_temperature_age_s", out.max_temperature_age_s, kPositive);
  run.number("max_given_up_share", out.max_given_up_share, {.min = 0, .max = 1});
  run.truth("park", out.park);
  read_after(run, "after_restart", restart.after_restart);
  read_after(run, "after_power_loss", restart.after_power_loss);
  run.finish();
}

void read_checks(TomlReader&& checks, StartChecks& out) {
  checks.number("stabiliser_band_k", out.stabiliser_band_k, {.min = 0, .above_min = true});
  checks.number("stabiliser_wait_s", out.stabiliser_wait_s, {.min = 0});
  checks.truth("hold_on_stabilisers", out.hold_on_stabilisers);
  checks.number("max_drift_nm_per_min", out.max_drift_nm_per_min, {.min = 0, .above_min = true});
  checks.number("drift_window_s", out.drift_window_s, {.min = 0, .above_min = true});
  checks.finish();
}

void read_serving(TomlReader&& serving, ServingRules& out) {
  serving.number("rebuild_period_s", out.rebuild_period_s, {.min = 0.1, .max = 3600});
  serving.truth("refuse_stale", out.refuse_stale);
  serving.truth("refuse_outside_domain", out.refuse_outside_domain);
  serving.truth("refuse_outside_limits", out.refuse_outside_limits);
  serving.number("max_age_s", out.max_age_s, {.min = 0, .above_min = true});
  serving.finish();
}

void read_thinning(TomlReader&& thinning, ThinningRules& out) {
  thinning.number("after_days", out.after_days, {.min = 0, .max = 36'500});
  thinning.number("every_s", out.every_s, {.min = 1, .max = 3600});
  thinning.choice("reducer", out.reducer, {"mean", "min", "max"}, Need::optional);
  thinning.finish();
}

void read_backup(TomlReader&& backup, BackupRules& out) {
  backup.text("folder", out.folder);
  backup.number("every_h", out.every_h, {.min = 0, .max = 8784});
  backup.integer("keep", out.keep, 1, 10'000);
  backup.finish();
}

void check_speed(TomlReader& clock, const CellDescription& cell) {
  if (cell.clock.speed == 1.0) return;
  for (const auto& device : cell.devices)
    if (!device.on_loopback())
      return clock.refuse(
          "speed", reasons::kSpeedNeedsLoopback,
          "found " + number_text(cell.clock.speed) + " with device " + shown(device.id) + " at " +
              shown(device.address) +
              ", expected 1: only a simulated cell on loopback has another time than the world's",
          ErrorCode::failed_precondition);
}

// A force by a voltage belongs to an axis of the cell, and is not the one that hangs there.
void check_force_of_sensor(TomlReader& reader, const DeviceDescription& device,
                           const CellDescription& cell) {
  if (const auto& motor = device.voltages.motor;
      motor && !motor->axis.symbol.empty() && cell.find_axis(motor->axis.name()) == nullptr)
    reader.refuse("axis", reasons::kBadChannel,
                  "found " + shown(motor->axis.name()) +
                      ", which no controller of this cell moves; expected the axis of the motor");
  const auto hanging = cell.force_channel();
  for (const auto& quantity : device.quantities())
    if (hanging && quantity.channel == *hanging)
      reader.refuse("channel", reasons::kDuplicateChannel,
                    "found " + shown(quantity.channel.name()) +
                        ", which is the force that [load] knows; expected another name, such as " +
                        "measured_force_N, or no [load]");
}

void check_drift_channel(TomlReader& reader, const DeviceDescription& device,
                         const CellDescription& cell) {
  const auto* length = device.length();
  if (length == nullptr || length->drift_channel.symbol.empty()) return;
  for (const auto& other : cell.devices)
    if (std::ranges::find(other.probes(), length->drift_channel, &ProbeDescription::channel) !=
        other.probes().end())
      return;
  reader.refuse("drift_channel", reasons::kBadChannel,
                "found " + shown(length->drift_channel.name()) +
                    ", which no probe of this cell reads; expected a thermometer of the cell");
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
    top.refuse("cell", reasons::kMissingKey,
               "found no [cell] section, expected one with name and database");
  read_cell(std::move(cell), out);
  std::string web_root;  // kept in the text: web_root_of()
  TomlReader web = section("web");
  web.text("root", web_root);
  web.finish();
  if (const auto* access = top.table("access"))
    read_access(TomlReader(*access, "access", problem), out.access);
  TomlReader clock = section("clock");
  TomlReader speed = clock;
  read_clock(std::move(clock), out.clock);
  read_run(section("run"), out.run, out.restart);
  read_checks(section("checks"), out.checks);
  read_serving(section("serving"), out.serving);
  read_backup(section("backup"), out.backup);
  read_thinning(section("thinning"), out.thinning);
  read_plausibility(section("plausibility"), out.plausibility);
  if (const auto* kinematics = top.table("kinematics"))
    read_kinematics(*kinematics, out.kinematics.emplace(), problem);
  TakenNames taken;
  taken.has_setups = root.contains("setup");
  read_robots(top, out, taken, problem);
  for (const auto* table : top.tables("device")) {
    const std::string place = "device " + std::to_string(out.devices.size() + 1);
    read_device(TomlReader(*table, place, problem), place, out.kinds, out.devices.emplace_back(),
                taken, problem);
  }
  if (out.devices.empty())
    top.refuse("device", reasons::kMissingKey, "found no [[device]], expected at least one");
  if (!problem.any()) complete_robots(top, out);
  for (const auto* table : top.tables("keep_out")) {
    const std::string place = "keep_out " + std::to_string(out.keep_outs.size() + 1);
    read_keep_out(TomlReader(*table, place, problem), place, out, problem);
  }
  static_cast<void>(read_closure(top, out, problem));  // kept in the text: closure_rules_of()
  for (const auto* table : top.tables("hold")) {
    const std::string place = "hold " + std::to_string(out.holds.size() + 1);
    read_hold(TomlReader(*table, place, problem), out);
  }
  for (const auto* table : top.tables("setup")) {
    const std::string place = "setup " + std::to_string(out.setups.size() + 1);
    read_setup(TomlReader(*table, place, problem), place, out, problem);
  }
  if (out.checks.hold_on_stabilisers) add_holds_of_stabilisers(out);
  if (const auto* load = top.table("load"))
    read_load(TomlReader(*load, "load", problem), out.load.emplace());
  if (const auto* correction = top.table("correction"))
    read_correction(TomlReader(*correction, "correction", problem), out, problem);
  for (const auto* table : top.tables("limit")) {
    const std::string place = "limit " + std::to_string(out.plausibility.limits.size() + 1);
    read_limit(TomlReader(*table, place, problem), channels_read(out), out.plausibility);
  }
  read_notify(top, out, problem);
  for (const auto* table : top.tables("certificate")) {
    const std::string place = "certificate " + std::to_string(out.certificates.size() + 1);
    read_certificate(TomlReader(*table, place, problem), out);
  }
  top.finish();
  if (const auto* actuator = out.load_actuator(); actuator && !out.load)
    top.refuse("load", reasons::kMissingKey,
               "found no [load] section beside the load actuator " + shown(actuator->id) +
                   ", expected one with max_n, the largest force it may ever apply");
  const auto tables = top.tables("device");
  for (std::size_t i = 0; i < out.devices.size() && i < tables.size(); ++i) {
    TomlReader reader(*tables[i], "device " + std::to_string(i + 1), problem);
    check_force_of_sensor(reader, out.devices[i], out);
    check_drift_channel(reader, out.devices[i], out);
  }
  check_speed(speed, out);
}

}  // namespace

Result<CellDescription> parse_cell_file(std::string_view text, const std::string& path,
                                        DeviceKinds kinds) {
  TomlProblem problem{.file_name = path, .first = {}};
  CellDescription cell;
  cell.kinds = kinds;
  try {
    read_file(parse_toml(text, path), cell, problem);
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, path));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  cell.database = beside(cell.database, path);
  cell.clock.file = beside(cell.clock.file, path);
  for (std::string* file :
       {&cell.access.certificate, &cell.access.key, &cell.access.authority, &cell.access.revoked})
    *file = beside(*file, path);
  cell.backup.folder = beside(cell.backup.folder, path);
  for (auto& receiver : cell.receivers)
    for (std::string* file : {&receiver.token_file, &receiver.password_file, &receiver.ca_file})
      *file = beside(*file, path);
  for (std::string* file : {&cell.watchdog.token_file, &cell.watchdog.ca_file})
    *file = beside(*file, path);
  cell.text = text;
  cell.hash = content_hash(text);
  return cell;
}

std::string web_root_of(const CellDescription& cell, const std::string& path) {
  try {
    return beside(parse_toml(cell.text)["web"]["root"].value_or(std::string()), path);
  } catch (const toml::parse_error&) {  // it was not made from a cell file
    return {};
  }
}

Result<CellDescription> read_cell_file(const std::string& path, DeviceKinds kinds) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return fail(ErrorCode::invalid_argument, reasons::kNotAFile,
                shown(path) + " is a folder, expected the cell file itself, such as " +
                    shown((std::filesystem::path(path) / "cell.toml").string()));
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return fail(
        ErrorCode::not_found, reasons::kNoFile,
        "cannot open the cell file " + shown(path) + ": check the path and its permissions");
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad())
    return fail(ErrorCode::not_found, reasons::kNoFile, "cannot read the cell file " + shown(path));
  return parse_cell_file(text, path, kinds);
}

std::string device_place(const CellDescription& cell, const std::string& path, std::size_t device,
                         std::string_view complaint) {
  try {
    const auto root = parse_toml(cell.text);
    const auto* table = root["device"][device].as_table();
    if (table == nullptr) return {};
    std::size_t line = table->source().begin.line;
    if (const auto* options = (*table)["options"].as_table())
      for (const auto& [name, value] : *options)
        if (complaint.find("option " + std::string(name.str()) + " ") != std::string_view::npos ||
            complaint.find("option '" + std::string(name.str()) + "'") != std::string_view::npos)
          line = value.source().begin.line;
    return at_line(path, line);
  } catch (const toml::parse_error&) {  // it was not made from a cell file
    return {};
  }
}

}  // namespace driftwise::formats
