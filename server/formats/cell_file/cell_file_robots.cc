#include "server/formats/cell_file/cell_file_robots.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

// An id stands before a dot in names of channels.
bool is_robot_id(const std::string& id) {
  return !id.empty() && std::isalpha(static_cast<unsigned char>(id.front())) &&
         std::ranges::all_of(id, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

void read_robot(TomlReader&& reader, RobotDescription& out, TomlProblem& problem) {
  reader.text("id", out.id, Need::required);
  if (!out.id.empty() && !is_robot_id(out.id))
    reader.refuse("id", reasons::kBadId,
                  "found " + shown(out.id) +
                      ", expected a letter, then letters, digits or '_': it stands before the "
                      "robot's channels, as in ma.q1_mm");
  reader.text("controller", out.controller);
  std::vector<std::string> axes;
  reader.texts("axes", axes);
  for (const auto& name : axes) {  // checked when the controller is known
    const auto cut = name.rfind('_');
    out.axes.push_back(cut == std::string::npos
                           ? Channel{name, ""}
                           : Channel{name.substr(0, cut), name.substr(cut + 1)});
  }
  reader.text("tool", out.tool);
  if (const auto* kinematics = reader.table("kinematics"))
    read_kinematics(*kinematics, out.kinematics.emplace(), problem);
  reader.finish();
}

const DeviceDescription* find_controller(const CellDescription& cell, const std::string& id) {
  const auto* device = cell.find_device(id);
  return device && device->role() == DeviceRole::motion ? device : nullptr;
}

std::vector<std::string> controllers_of(const CellDescription& cell) {
  std::vector<std::string> ids;
  for (const auto& device : cell.devices)
    if (device.role() == DeviceRole::motion) ids.push_back(device.id);
  return ids;
}

// robot: its axes only; empty: all.
std::vector<Channel> axes_of(const DeviceDescription& controller, const std::string& robot) {
  std::vector<Channel> axes;
  for (const auto& axis : controller.axes())
    if (robot.empty() || robot_of(axis.channel.symbol) == robot) axes.push_back(axis.channel);
  return axes;
}

template <class Names>
std::string joined_names(const Names& names) {
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + std::string(name);
  return list.empty() ? "none" : list;
}

std::vector<std::string> names_of_axes(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(channel.name());
  return names;
}

void complete_robot(TomlReader& top, const CellDescription& cell, RobotDescription& robot) {
  const auto refuse = [&](Reason reason, const std::string& sentence) {
    top.refuse("robot", reason, "robot " + shown(robot.id) + ": " + sentence);
  };
  const auto controllers = controllers_of(cell);
  if (robot.controller.empty() && controllers.size() == 1) robot.controller = controllers.front();
  const auto* controller = find_controller(cell, robot.controller);
  if (!controller)
    return refuse(
        reasons::kBadController,
        "controller: found " + shown(robot.controller) +
            ", expected the id of a motion controller of this cell: " + joined_names(controllers));
  // With several robots the name of an axis says whose it is, also on a controller that they share.
  const auto all = axes_of(*controller, cell.has_several_robots() ? robot.id : "");
  if (robot.axes.empty()) robot.axes = all;
  if (robot.axes.empty())
    return refuse(reasons::kBadChannel, "axes: found none, expected [[device.axis]] of " +
                                            shown(controller->id) + " whose channel begins with " +
                                            shown(robot.id + "."));
  for (const auto& axis : robot.axes)
    if (std::ranges::find(all, axis) == all.end())
      return refuse(reasons::kBadChannel, "axes: found " + shown(axis.name()) +
                                              ", expected axes of " + shown(controller->id) + ": " +
                                              joined_names(names_of_axes(all)));
}

}  // namespace

void read_robots(TomlReader& top, CellDescription& out, TakenNames& taken, TomlProblem& problem) {
  std::set<std::string> ids;
  for (const auto* table : top.tables("robot")) {
    const std::string place = "robot " + std::to_string(out.robots.size() + 1);
    TomlReader reader(*table, place, problem);
    TomlReader line = reader;
    auto& robot = out.robots.emplace_back();
    read_robot(std::move(reader), robot, problem);
    if (!ids.insert(robot.id).second)
      line.refuse("id", reasons::kDuplicateId,
                  "found " + shown(robot.id) + ", which another robot has already");
  }
  if (out.robots.size() > 1) taken.robots = ids;
}

void complete_robots(TomlReader& top, CellDescription& out) {
  if (out.robots.empty()) {
    const auto controllers = controllers_of(out);
    if (controllers.size() != 1) return;  // none, or which is meant is not said: refused on use
    out.robots.push_back({.id = {},
                          .controller = controllers.front(),
                          .axes = axes_of(*find_controller(out, controllers.front()), ""),
                          .tool = {},
                          .kinematics = out.kinematics});
    return;
  }
  if (out.kinematics)
    top.refuse("kinematics", reasons::kTwoKinematics,
               "found [kinematics] beside [[robot]], expected [robot.kinematics] below the robot "
               "that it describes");
  std::vector<std::string> known;
  for (auto& robot : out.robots) {
    complete_robot(top, out, robot);
    for (const auto& name : names_of_axes(robot.axes)) {
      if (std::ranges::find(known, name) != known.end())
        top.refuse("robot", reasons::kDuplicateChannel,
                   "robot " + shown(robot.id) + ": axes: found " + shown(name) +
                       ", which another robot has already");
      known.push_back(name);
    }
  }
  for (const auto& axis : out.motor_channels())
    if (std::ranges::find(known, axis.name()) == known.end())
      top.refuse("robot", reasons::kAxisOfNoRobot,
                 "found the axis " + shown(axis.name()) +
                     ", which no robot has, expected it among the axes of one: nothing would "
                     "bring it to its zero");
  out.kinematics = out.robots.front().kinematics;
}

}  // namespace driftwise::formats
