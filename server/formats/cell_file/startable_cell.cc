#include "server/formats/cell_file/startable_cell.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "server/core/reasons.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

std::vector<std::size_t> with_role(const CellDescription& cell, DeviceRole role) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < cell.devices.size(); ++i)
    if (cell.devices[i].role() == role) found.push_back(i);
  return found;
}

// "\"interferometer-adapter\" or \"newport-lds1000\""
template <class Takes>
std::string kinds_that(const CellDescription& cell, Takes takes) {
  std::string text;
  for (const auto* kind : cell.kinds)
    if (takes(kind->role)) text += (text.empty() ? "" : " or ") + shown(kind->id);
  return text;
}

// A setup reads only the instruments that it names, so one may stand at another place in each.
bool share_no_setup(const CellDescription& cell, const DeviceDescription& one,
                    const DeviceDescription& other) {
  if (cell.setups.empty() || !measures_pose(one.role()) || !measures_pose(other.role()))
    return false;
  const auto names = [](const SetupDescription& setup, const std::string& id) {
    return std::ranges::find(setup.coordinates, id, &SetupCoordinate::device) !=
               setup.coordinates.end() ||
           std::ranges::find(setup.confirmations, id, &SetupConfirmation::device) !=
               setup.confirmations.end();
  };
  return std::ranges::none_of(cell.setups, [&](const SetupDescription& setup) {
    return names(setup, one.id) && names(setup, other.id);
  });
}

std::string option_of(const DeviceDescription& device, const OutputOption& option) {
  const auto stated = device.options.find(std::string(option.name));
  return stated == device.options.end() ? std::string(option.preset) : stated->second;
}

class StartCheck {
 public:
  StartCheck(const CellDescription& cell, const std::string& path, const toml::table& root,
             TomlProblem& problem)
      : cell_(cell),
        path_(path),
        problem_(problem),
        top_(root, "", problem),
        devices_(top_.tables("device")),
        robots_(top_.tables("robot")) {
    if (const auto* kinematics = top_.table("kinematics")) kinematics_ = kinematics;
  }

  void check() {
    check_roles();
    for (std::size_t i = 0; i < devices_.size() && i < cell_.devices.size(); ++i) check_outputs(i);
    check_channels();
    check_places();
    check_doors();
    if (kinematics_ != nullptr && cell_.kinematics)
      check_geometry(*kinematics_, "kinematics", *cell_.kinematics,
                     cell_.robots.empty() ? nullptr : &cell_.robots.front());
    for (std::size_t i = 0; i < robots_.size() && i < cell_.robots.size(); ++i) {
      const auto* table = (*robots_[i])["kinematics"].as_table();
      if (table != nullptr && cell_.robots[i].kinematics)
        check_geometry(*table, "robot " + std::to_string(i + 1) + ", kinematics",
                       *cell_.robots[i].kinematics, &cell_.robots[i]);
    }
  }

 private:
  struct Giver {
    std::size_t device;
    std::string channel;
  };

  std::string place_of(std::size_t device) const { return "device " + std::to_string(device + 1); }

  void refuse_device(std::size_t device, const char* key, Reason reason,
                     const std::string& sentence) {
    if (device < devices_.size())
      TomlReader(*devices_[device], place_of(device), problem_).refuse(key, reason, sentence);
  }

  void check_roles() {
    const auto controllers = with_role(cell_, DeviceRole::motion);
    const auto is_motion = [](DeviceRole role) { return role == DeviceRole::motion; };
    if (controllers.empty())
      top_.refuse("device", reasons::kNoController,
                  "found no motion controller, expected a [[device]] of kind " +
                      kinds_that(cell_, is_motion) + ": it moves the axes");
    for (const auto i : controllers)
      if (controllers.size() > 1 &&
          std::ranges::find(cell_.robots, cell_.devices[i].id, &RobotDescription::controller) ==
              cell_.robots.end())
        refuse_device(i, "id", reasons::kTwoControllers,
                      "found " + shown(cell_.devices[i].id) + ", one of " +
                          std::to_string(controllers.size()) +
                          " motion controllers, which no [[robot]] names, expected a [[robot]] "
                          "with its controller for each");
    if (std::ranges::none_of(cell_.devices, [](const auto& d) { return measures_pose(d.role()); }))
      top_.refuse("device", reasons::kNoInstrument,
                  "found no instrument that measures the pose, expected a [[device]] of kind " +
                      kinds_that(cell_, measures_pose) + ": a run has nothing to read");
    if (const auto loads = with_role(cell_, DeviceRole::load); loads.size() > 1)
      refuse_device(loads[1], "kind", reasons::kTwoLoads,
                    "found " + shown(cell_.devices[loads[1]].kind) +
                        ", which is a second load actuator, expected one in a cell");
    for (const auto i : with_role(cell_, DeviceRole::probe))
      refuse_device(i, "kind", reasons::kRoleNotUsed,
                    "found " + shown(cell_.devices[i].kind) +
                        ", a touch probe, which nothing in this version reads: leave the device "
                        "out of the cell file");
  }

  // A channel has one giver in every point. Coordinates (and their spread) are the exception of a
  // cell with [[setup]], and so is what stands in no set-up together. Only a start asks for it:
  // cell files of old records stay readable.
  void check_channels() {
    std::map<std::string, std::size_t> givers;
    for (std::size_t i = 0; i < cell_.devices.size(); ++i) {
      for (const auto& channel : cell_.devices[i].channels) {
        const auto [giver, is_new] = givers.try_emplace(channel.name(), i);
        if (is_new || may_give_both(giver->second, i, channel)) continue;
        refuse_device(i, has_options(i) ? "options" : "id", reasons::kDuplicateChannel,
                      "found " + shown(channel.name()) + ", which device " +
                          shown(cell_.devices[giver->second].id) +
                          " gives already, expected a channel of its own: name it in options (of "
                          "an interferometer air_channel and level_channel; \"\": none)");
      }
    }
  }

  bool has_options(std::size_t device) const {
    return device < devices_.size() && devices_[device]->contains("options");
  }

  bool may_give_both(std::size_t first, std::size_t second, const Channel& channel) const {
    if (first == second || cell_.setups.empty()) return false;
    std::string_view symbol = without_robot(channel.symbol);
    if (symbol.ends_with("_std")) symbol.remove_suffix(4);
    return is_pose_symbol(symbol) ||
           share_no_setup(cell_, cell_.devices[first], cell_.devices[second]);
  }

  bool shares_line(const DeviceDescription& device) const {
    const auto* kind = find_kind(cell_.kinds, device.kind);
    return kind != nullptr && kind->shares_line;
  }

  // One address, or serial line, speaks one protocol.
  void check_places() {
    for (std::size_t i = 0; i < cell_.devices.size(); ++i) {
      const auto& one = cell_.devices[i];
      for (std::size_t k = 0; k < i; ++k) {
        const auto& other = cell_.devices[k];
        if (other.kind == one.kind || !is_one_place(one.address, other.address) ||
            (shares_line(one) && shares_line(other)))
          continue;
        refuse_device(i, "address", reasons::kBadAddress,
                      "found " + shown(one.address) + ", which is the address of device " +
                          shown(other.id) + ", a " + shown(other.kind) + ": device " +
                          shown(one.id) + ", a " + shown(one.kind) +
                          ", speaks another protocol, expected an address of its own");
        break;
      }
    }
  }

  struct Door {
    const char *section, *key;
    const std::string* address;
  };

  // Doors of the daemon, each with a port of its own that no device has; and its record.
  void check_doors() {
    const auto* cell_table = top_.table("cell");
    const auto* access_table = top_.table("access");
    const auto& access = cell_.access;
    const Door doors[] = {{"cell", "listen", &cell_.listen},
                          {"cell", "target_line", &cell_.target_line},
                          {"cell", "http", &cell_.http},
                          {"access", "listen", &access.listen},
                          {"access", "http", &access.http},
                          {"access", "target_line", &access.target_line},
                          {"access", "plain_target_line", &access.plain_target_line}};
    for (std::size_t i = 0; i < std::size(doors); ++i) {
      const Door& door = doors[i];
      const auto* table = door.section == std::string_view("cell") ? cell_table : access_table;
      if (table == nullptr) continue;
      const auto refuse = [&](const std::string& owner) {
        TomlReader(*table, door.section, problem_)
            .refuse(door.key, reasons::kBadAddress,
                    "found " + shown(*door.address) + ", which is the address of " + owner +
                        ", expected a port of its own");
      };
      for (std::size_t k = 0; k < i; ++k)
        if (is_one_place(*door.address, *doors[k].address))
          refuse(std::string(doors[k].key) + " = " + shown(*doors[k].address) + " of [" +
                 doors[k].section + "]");
      for (const auto& device : cell_.devices)
        if (is_one_place(*door.address, device.address)) refuse("device " + shown(device.id));
    }
    if (cell_table == nullptr) return;
    std::error_code ignored;
    if (std::filesystem::weakly_canonical(cell_.database, ignored) ==
        std::filesystem::weakly_canonical(std::filesystem::absolute(path_, ignored), ignored))
      TomlReader(*cell_table, "cell", problem_)
          .refuse("database", reasons::kBadOption,
                  "found " + shown(cell_.database) +
                      ", which is this cell file, expected a file of its own for the record");
  }

  // output: of the device at its place, "" for a device with one; channel: what it becomes here.
  void take(std::size_t device, TomlReader reader, const char* key, const std::string& output,
            const std::string& found, const std::string& channel) {
    const auto& one = cell_.devices[device];
    auto& givers = taken_[place_text(one) + "\n" + output];
    for (const auto& giver : givers) {
      const auto& other = cell_.devices[giver.device];
      if (giver.device != device && share_no_setup(cell_, one, other)) continue;
      reader.refuse(key, reasons::kDuplicateOutput,
                    "found " + found + ", which is " + shown(giver.channel) +
                        (giver.device == device ? "" : " of device " + shown(other.id)) +
                        " already: " + shown(channel) +
                        " would be the same one, expected an output of its own");
    }
    givers.push_back({device, channel});
  }

  // Kind, address and the options that choose among the outputs there.
  std::string place_text(const DeviceDescription& device) const {
    std::string text = device.kind + "\n" + device.address;
    if (const auto* kind = find_kind(cell_.kinds, device.kind))
      for (const auto& option : kind->output_options) text += "\n" + option_of(device, option);
    return text;
  }

  std::string found_address(const DeviceDescription& device) const {
    std::string text = shown(device.address);
    if (const auto* kind = find_kind(cell_.kinds, device.kind))
      for (const auto& option : kind->output_options)
        text += ", " + std::string(option.name) + " " + option_of(device, option);
    return text;
  }

  void check_outputs(std::size_t i) {
    const auto& device = cell_.devices[i];
    TomlReader reader(*devices_[i], place_of(i), problem_);
    bool has_parts = false;
    const auto each = [&](const char* key, const char* choice, const auto& parts, auto output,
                          auto channel) {
      if (parts.empty()) return;  // another kind may have an option of this name
      const auto tables = reader.tables(key);
      for (std::size_t k = 0; k < tables.size() && k < parts.size(); ++k) {
        has_parts = true;
        const std::string text = output(parts[k]);
        take(i,
             TomlReader(*tables[k], place_of(i) + ", " + key + " " + std::to_string(k + 1),
                        problem_),
             choice, text, text + " at " + found_address(device), channel(parts[k]));
      }
    };
    const auto name = [](const auto& part) { return part.channel.name(); };
    const auto input = [](const auto& part) { return std::to_string(part.input); };
    each(
        "axis", "device_axis", device.axes(), [](const auto& axis) { return axis.device_axis; },
        name);
    each(
        "angle", "device_axis", device.angles(),
        [](const auto& angle) { return std::to_string(angle.device_axis); }, name);
    each("probe", "input", device.probes(), input, name);
    each("sensor", "input", device.voltages.sensors, input, [&](const auto& sensor) {
      return sensor.channel.symbol.empty() ? device.id : sensor.channel.name();
    });
    if (!has_parts)
      take(i, reader, "address", "", found_address(device),
           device.channels.empty() ? device.id : device.channels.front().name());
  }

  // robot: whose geometry it is; nullptr: no controller moves it.
  void check_geometry(const toml::table& table, const std::string& place,
                      const KinematicsDescription& kinematics, const RobotDescription* robot) {
    const std::string prefix =
        robot != nullptr && cell_.has_several_robots() ? robot->id + "." : "";
    if (robot != nullptr) {
      check_motors(table, place, "axis", kinematics.axes, *robot, prefix);
      check_motors(table, place, "branch", kinematics.branches, *robot, prefix);
      check_motors(table, place, "link", kinematics.links, *robot, prefix);
    }
    check_poses(table, place, kinematics, prefix);
  }

  // A motor that no axis is has no readback, so nothing would ever be compared with the geometry.
  // Joints of an arm turn, and an axis of a cell is a length: their geometry serves targets only.
  template <class Parts>
  void check_motors(const toml::table& table, const std::string& place, const char* key,
                    const Parts& parts, const RobotDescription& robot, const std::string& prefix) {
    TomlReader reader(table, place, problem_);
    const auto tables = reader.tables(key);
    for (std::size_t k = 0; k < tables.size() && k < parts.size(); ++k) {
      if (is_angle(parts[k].motor.unit)) continue;
      const std::string motor = prefix + parts[k].motor.name();
      if (std::ranges::find(robot.axes, motor, &Channel::name) != robot.axes.end()) continue;
      std::string names;
      for (const auto& axis : robot.axes)
        names += (names.empty() ? "" : ", ") + axis.name().substr(prefix.size());
      TomlReader(*tables[k], place + ", " + key + " " + std::to_string(k + 1), problem_)
          .refuse("motor", reasons::kUnknownAxis,
                  "found " + shown(parts[k].motor.name()) + ", which controller " +
                      shown(robot.controller) + " does not move" +
                      (prefix.empty() ? "" : " for robot " + shown(robot.id)) +
                      ", expected one of " + names + ": the geometry would test no reading");
    }
  }

  void check_poses(const toml::table& table, const std::string& place,
                   const KinematicsDescription& kinematics, const std::string& robot) {
    std::set<std::string> measured;
    for (const auto& device : cell_.devices) {
      if (const auto* length = device.length()) measured.insert(length->channel.name());
      for (const auto& angle : device.angles()) measured.insert(angle.channel.name());
    }
    TomlReader reader(table, place, problem_);
    const auto axes = reader.tables("axis");
    for (std::size_t k = 0; k < axes.size() && k < kinematics.axes.size(); ++k) {
      const std::string pose = robot + kinematics.axes[k].pose.name();
      if (measured.contains(pose)) continue;
      std::string names;
      for (const auto& one : measured) names += (names.empty() ? "" : ", ") + one;
      TomlReader(*axes[k], place + ", axis " + std::to_string(k + 1), problem_)
          .refuse("pose", reasons::kNotMeasured,
                  "found " + shown(pose) +
                      ", which no device of this cell measures, expected one "
                      "of " +
                      names + ": the geometry would test no reading");
    }
  }

  const CellDescription& cell_;
  const std::string& path_;  // of the cell file
  TomlProblem& problem_;
  TomlReader top_;
  std::vector<const toml::table*> devices_, robots_;
  const toml::table* kinematics_ = nullptr;
  std::map<std::string, std::vector<Giver>> taken_;
};

}  // namespace

Result<void> check_startable(const CellDescription& cell, const std::string& path) {
  TomlProblem problem{.file_name = path, .first = {}};
  try {
    const auto root = parse_toml(cell.text, path);
    StartCheck(cell, path, root, problem).check();
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, path));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  return {};
}

}  // namespace driftwise::formats
