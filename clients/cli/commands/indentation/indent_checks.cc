#include "clients/cli/commands/indentation/indent_checks.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "clients/cli/commands/indentation/indent_motors.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/configuration_service.grpc.pb.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/formats/text/toml_text.h"
#include "server/indentation/planned_places.h"

namespace driftwise::cli {
namespace {

constexpr const char* kCoordinates[] = {".x_mm", ".y_mm", ".z_mm", ".rx_arcsec", ".ry_arcsec"};
constexpr auto kReadLimit = std::chrono::seconds(20);  // wall: devices may just be connecting

struct CellInventory {
  std::map<std::string, v1::Axis> axes{};  // by channel
  std::set<std::string> robots{}, measured{}, thermometers{};
};

std::string listed(const std::set<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

Failure bad(Reason reason, std::string message) {
  return {ExitCode::bad_input, "invalid_argument", reason, std::move(message)};
}

CellInventory inventory_of(const Connection& connection) {
  CellInventory cell;
  const auto devices =
      connection.ask(&v1::CellService::Stub::ListDevices, v1::ListDevicesRequest{}).devices();
  for (const auto& device : devices) {
    for (const auto& axis : device.axes()) {
      cell.axes[axis.channel()] = axis;
      if (const auto dot = axis.channel().find('.'); dot != std::string::npos)
        cell.robots.insert(axis.channel().substr(0, dot));
    }
    for (const auto& probe : device.probes()) cell.thermometers.insert(probe.channel());
    if (!device.length_channel().empty()) cell.measured.insert(device.length_channel());
    cell.measured.insert(device.angle_channels().begin(), device.angle_channels().end());
  }
  return cell;
}

// [[robot]] tool of the present cell file; empty: it does not say.
std::string tool_of(const Connection& connection, const std::string& robot) {
  const auto text =
      connection
          .ask(&v1::ConfigurationService::Stub::GetConfiguration, v1::GetConfigurationRequest{})
          .text();
  const auto root = formats::parse_toml(text);
  if (const auto* robots = root.get_as<toml::array>("robot"))
    for (const auto& one : *robots)
      if (const auto* table = one.as_table())
        if ((*table)["id"].value_or(std::string()) == robot)
          return (*table)["tool"].value_or(std::string());
  return {};
}

void check_names(const CellInventory& cell, const formats::IndentationFile& file) {
  for (const auto& [key, robot] : {std::pair{"above", file.above}, std::pair{"below", file.below}})
    if (!cell.robots.contains(robot))
      throw bad(reasons::kNoChannel, std::string(key) + " = " + shown(robot) +
                                         ": this cell has no such robot, it has " +
                                         listed(cell.robots));
  for (const char* name : kCoordinates)
    if (!cell.measured.contains(file.above + name))
      throw bad(reasons::kNoChannel, "above = " + shown(file.above) + ": no instrument gives " +
                                         file.above + name + ", measured are " +
                                         listed(cell.measured));
  for (const auto& name : file.temperatures)
    if (!cell.thermometers.contains(name))
      throw bad(reasons::kNoChannel, "temperatures: found " + shown(name) +
                                         ", which no thermometer of this cell gives; it has " +
                                         listed(cell.thermometers));
}

std::set<std::string> setup_names(const Connection& connection) {
  const auto names =
      connection.ask(&v1::CellService::Stub::ListDevices, v1::ListDevicesRequest{}).setup_names();
  return {names.begin(), names.end()};
}

// A set-up of the other robot, or a lost device: the contact would be made, and nothing could say
// where. Asked of the stream that the procedure reads: latest values have what the set-up in use
// leaves out of it.
void check_is_read(const Connection& connection, const formats::IndentationFile& file) {
  std::set<std::string> missing;
  for (const char* name : kCoordinates) missing.insert(file.above + name);
  for (const char* name : {".q1_mm", ".q2_mm", ".q3_mm"}) missing.insert(file.above + name);
  const auto until = std::chrono::steady_clock::now() + kReadLimit;
  connection.follow(&v1::CellService::Stub::WatchReadings, v1::WatchReadingsRequest{},
                    [&](const v1::WatchReadingsResponse& response) {
                      for (const auto& value : response.reading().values())
                        if (value.has_value())
                          std::erase_if(missing, [&](const std::string& channel) {
                            const auto names = live_names(channel);
                            return std::ranges::find(names, value.channel()) != names.end();
                          });
                      return !missing.empty() && std::chrono::steady_clock::now() < until;
                    });
  if (missing.empty()) return;
  const auto setups = setup_names(connection);
  const std::string devices = "`driftwise status` says which devices do not answer";
  throw Failure{
      ExitCode::refused, "failed_precondition", reasons::kChannelMissing,
      "not being read: " + listed(missing) + ", which the indentation needs; nothing was moved. " +
          (setups.empty() ? devices
                          : "The set-up of the last run stays in use: measure two points in one "
                            "that reads them, driftwise run start TRAJECTORY --setup NAME, set-ups "
                            "are " +
                                listed(setups) + "; " + devices)};
}

void check_inside_limits(const CellInventory& cell, const Motors& motors,
                         const std::string& place) {
  for (const auto& [channel, value_mm] : motors) {
    const auto axis = cell.axes.find(channel);
    if (axis == cell.axes.end())
      throw bad(reasons::kNoChannel,
                place + " needs " + channel + ", which is no axis of this cell");
    if (value_mm < axis->second.min_mm() || value_mm > axis->second.max_mm())
      throw bad(reasons::kOutsideLimits,
                place + " needs " + channel + " = " + number_text(value_mm) + " mm, soft limits " +
                    number_text(axis->second.min_mm()) + " to " +
                    number_text(axis->second.max_mm()) + ": choose other places or heights");
  }
}

// ending: "_mm"; own: what the instrument's own name has before it.
std::vector<std::string> with_own_name(const std::string& coordinate, std::string_view ending,
                                       std::string_view own) {
  std::string name = coordinate;
  name.insert(name.size() - ending.size(), own);
  return {std::move(name), coordinate};
}

}  // namespace

std::vector<std::string> live_names(const std::string& coordinate) {
  for (const auto& [ending, own] : {std::pair{"_mm", "_path"}, {"_arcsec", "_raw"}})
    if (coordinate.ends_with(ending)) return with_own_name(coordinate, ending, own);
  return {coordinate};
}

void check_against_cell(const Connection& connection, const formats::IndentationFile& file) {
  const auto cell = inventory_of(connection);
  check_names(cell, file);
  const auto mounted = tool_of(connection, file.above);
  if (!mounted.empty() && mounted != file.rules.tool)
    throw Failure{ExitCode::refused, "failed_precondition", reasons::kOtherTool,
                  "tool id " + shown(file.rules.tool) + ", and the cell file says that robot " +
                      shown(file.above) + " carries " + shown(mounted) +
                      ": correct the one that is wrong"};

  IndentMotors motors(connection, file);
  const auto& rules = file.rules;
  IndentPose pose{.z_mm = rules.work_mm, .height_mm = rules.approach.depart_mm};
  const auto check = [&](const std::string& robot, const std::string& place) {
    const auto found = motors.of(robot, pose);
    if (!found)
      throw Failure{found.error().code == ErrorCode::invalid_argument ? ExitCode::bad_input
                                                                      : ExitCode::refused,
                    std::string(to_string(found.error().code)), found.error().reason,
                    place + ": " + found.error().message};
    check_inside_limits(cell, *found, place);
  };
  for (const auto& place : indentation::planned_places(rules)) {
    pose.x_mm = place.x_mm;
    pose.y_mm = place.y_mm;
    check(file.above, place.name);
  }
  for (const auto& height : indentation::planned_heights(rules)) {
    pose.height_mm = height.height_mm;
    check(file.below, height.name);
  }
  check_is_read(connection, file);
}

}  // namespace driftwise::cli
