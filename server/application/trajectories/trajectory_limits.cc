#include "server/application/trajectories/trajectory_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/kinematics/mechanism.h"
#include "server/plans/robot_parts.h"

namespace driftwise::application {
namespace {

// Collects what lies outside; the first is named.
class Outside {
 public:
  explicit Outside(const std::string& name) : name_(name) {}

  // found: what stands in the file for it.
  void check(std::size_t row, const std::string& found, double value_mm,
             const AxisDescription& axis) {
    if (value_mm >= axis.min_mm && value_mm <= axis.max_mm) return;
    if (count_++ == 0)
      first_ = fmt::format("{}: row {}: {}, the soft limits of axis {} are {:g} to {:g} mm", name_,
                           row + 1, found, axis.device_axis, axis.min_mm, axis.max_mm);
  }
  Result<std::string> result() const {
    if (count_ == 0) return std::string();
    auto sentence = first_;
    if (count_ > 1) sentence += fmt::format(" (and {} more values outside)", count_ - 1);
    return fail(ErrorCode::out_of_range, reasons::kSoftLimit, sentence);
  }

 private:
  const std::string& name_;
  std::size_t count_ = 0;
  std::string first_;
};

// Column by column: each coordinate of the file is one axis.
Result<std::string> check_columns(const std::vector<AxisDescription>& axes,
                                  const std::vector<std::size_t>& axis_of_column,
                                  const Trajectory& trajectory, const std::string& name) {
  Outside outside(name);
  for (std::size_t row = 0; row < trajectory.points.size(); ++row)
    for (std::size_t i = 0; i < axis_of_column.size(); ++i) {
      const double mm = trajectory.points[row].target[i];
      outside.check(row, fmt::format("{} = {} mm", trajectory.coordinates[i].name(), mm), mm,
                    axes[axis_of_column[i]]);
    }
  return outside.result();
}

// The place of a channel in a list; its size when it is not there.
std::size_t place_of(const std::vector<Channel>& list, const Channel& channel) {
  return static_cast<std::size_t>(std::ranges::find(list, channel) - list.begin());
}

Result<std::string> check_poses(const CellDescription& description,
                                const std::vector<AxisDescription>& axes,
                                const Trajectory& trajectory, const std::string& name) {
  if (!description.kinematics)
    return std::string(
        "whether the axes reach these poses is only checked at each move: the cell has no "
        "[kinematics]");
  DRIFTWISE_TRY(const auto mechanism, kinematics::make_mechanism(*description.kinematics));
  const auto& inputs = mechanism->inputs();
  if (mechanism->predicts_pose()) return std::string();
  for (const auto& coordinate : trajectory.coordinates)
    if (place_of(inputs, coordinate) == inputs.size())
      return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
                  fmt::format("column {}: the cell's kinematics has no such pose coordinate",
                              coordinate.name()));
  const auto nominal = kinematics::nominal_values(mechanism->parameters());
  Outside outside(name);
  for (std::size_t row = 0; row < trajectory.points.size(); ++row) {
    std::vector<double> pose_mm(inputs.size(), 0.0);
    std::string found;
    for (std::size_t i = 0; i < trajectory.coordinates.size(); ++i) {
      const double mm = trajectory.points[row].target[i];
      pose_mm[place_of(inputs, trajectory.coordinates[i])] = mm;
      found += fmt::format("{}{} = {}", i ? ", " : "", trajectory.coordinates[i].name(), mm);
    }
    const auto q = mechanism->predict(pose_mm, nominal).value;
    for (const auto& axis : axes) {
      const auto output = place_of(mechanism->outputs(), axis.channel);
      if (output == mechanism->outputs().size()) continue;
      const double q_mm = q[static_cast<Eigen::Index>(output)];
      outside.check(row, fmt::format("{}: needs {} = {:.4f} mm", found, axis.channel.name(), q_mm),
                    q_mm, axis);
    }
  }
  return outside.result();
}

std::string list_of_axes(const std::vector<AxisDescription>& axes) {
  std::string list;
  for (const auto& axis : axes) list += (list.empty() ? "" : ", ") + axis.channel.name();
  return list;
}

Result<std::string> check_limits_of_one(const CellDescription& description,
                                        const Trajectory& trajectory, const std::string& name) {
  const auto axes = description.axes();
  if (axes.size() != trajectory.coordinates.size()) {
    std::string found;
    for (const auto& channel : trajectory.coordinates)
      found += (found.empty() ? "" : ", ") + channel.name();
    return fail(
        ErrorCode::invalid_argument, reasons::kWrongCoordinates,
        fmt::format("{}: found the coordinates {}, expected one for each axis of cell '{}': "
                    "{}, or a pose with as many coordinates",
                    name, found, description.name, list_of_axes(axes)));
  }
  const auto& first = trajectory.coordinates.front();
  // A rotation is no motor coordinate, also not of the only axis.
  if (is_pose_symbol(first.symbol) && (axes.size() > 1 || is_angle(first.unit)))
    return check_poses(description, axes, trajectory, name);
  std::vector<std::size_t> axis_of_column;
  for (const auto& channel : trajectory.coordinates) {
    auto found = std::ranges::find(axes, channel, &AxisDescription::channel);
    if (found == axes.end() && is_pose_symbol(channel.symbol))
      found = axes.begin();  // the only one
    if (found == axes.end())
      return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
                  fmt::format("column {}: no axis of cell '{}' has that name, its axes are {} ...",
                              channel.name(), description.name, axes.front().channel.name()));
    axis_of_column.push_back(static_cast<std::size_t>(found - axes.begin()));
  }
  return check_columns(axes, axis_of_column, trajectory, name);
}

tl::unexpected<Error> wrong_column(const Channel& column, const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
              fmt::format("column {}: {}", column.name(), sentence));
}

std::string list_of_robots(const CellDescription& description) {
  std::string list;
  for (const auto& robot : description.robots) list += (list.empty() ? "" : ", ") + robot.id;
  return list;
}

Result<void> check_robot_of_column(const CellDescription& description, const Channel& column) {
  const std::string id(robot_of(column.symbol));
  if (id.empty())
    return wrong_column(column, fmt::format("this cell has the robots {}: say whose it is, as in "
                                            "{}.{}",
                                            list_of_robots(description),
                                            description.robots.front().id, column.name()));
  const auto* robot = description.find_robot(id);
  if (!robot)
    return wrong_column(column, fmt::format("this cell has no robot '{}', its robots are {}", id,
                                            list_of_robots(description)));
  if (!is_motor_symbol(without_robot(column.symbol)) ||
      std::ranges::find(robot->axes, column) != robot->axes.end())
    return {};
  std::string axes;
  for (const auto& axis : robot->axes) axes += (axes.empty() ? "" : ", ") + axis.name();
  return wrong_column(column,
                      fmt::format("robot '{}' has no such axis, its axes are {}", id, axes));
}

// The columns of one robot, without its id.
Trajectory poses_of(const Trajectory& trajectory, const std::string& robot) {
  Trajectory part;
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < trajectory.coordinates.size(); ++i) {
    const auto& column = trajectory.coordinates[i];
    if (robot_of(column.symbol) != robot) continue;
    part.coordinates.push_back({std::string(without_robot(column.symbol)), column.unit});
    columns.push_back(i);
  }
  for (const auto& row : trajectory.points) {
    auto& point = part.points.emplace_back(row);
    point.target.clear();
    for (const auto column : columns) point.target.push_back(row.target[column]);
  }
  return part;
}

// Motor coordinates of any of the robots, each with all its axes; or poses of any of them.
Result<std::string> check_limits_of_robots(const CellDescription& description,
                                           const Trajectory& trajectory, const std::string& name) {
  for (const auto& column : trajectory.coordinates)
    DRIFTWISE_RETURN_IF_ERROR(check_robot_of_column(description, column));
  const auto& first = trajectory.coordinates.front();
  if (is_pose_symbol(without_robot(first.symbol))) {
    std::string unchecked;
    for (const auto& robot : description.robots) {
      const auto of_robot = poses_of(trajectory, robot.id);
      if (of_robot.coordinates.empty()) continue;
      auto part = plans::part_of_robot(description, robot.id);
      part.kinematics = robot.kinematics;
      const auto axes = part.axes();
      if (!part.kinematics || of_robot.coordinates.size() != axes.size()) {
        unchecked += (unchecked.empty() ? "" : ", ") + robot.id;
        continue;
      }
      DRIFTWISE_RETURN_IF_ERROR(check_poses(part, axes, of_robot, name));
    }
    if (unchecked.empty()) return std::string();
    return fmt::format(
        "whether the axes of {} reach these poses is checked when the run begins, "
        "by the serving plan",
        unchecked);
  }
  const auto axes = description.axes();
  std::vector<std::size_t> axis_of_column;
  for (const auto& column : trajectory.coordinates)
    axis_of_column.push_back(static_cast<std::size_t>(
        std::ranges::find(axes, column, &AxisDescription::channel) - axes.begin()));
  for (const auto& robot : description.robots) {
    const bool is_named = std::ranges::any_of(trajectory.coordinates, [&robot](const auto& column) {
      return robot_of(column.symbol) == robot.id;
    });
    for (const auto& axis : robot.axes)
      if (is_named &&
          std::ranges::find(trajectory.coordinates, axis) == trajectory.coordinates.end())
        return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
                    fmt::format("{}: robot '{}' is moved without a column {}: name all of its axes",
                                name, robot.id, axis.name()));
  }
  return check_columns(axes, axis_of_column, trajectory, name);
}

}  // namespace

Result<std::string> check_trajectory_limits(const CellDescription& description,
                                            const Trajectory& trajectory, const std::string& name) {
  return description.has_several_robots() ? check_limits_of_robots(description, trajectory, name)
                                          : check_limits_of_one(description, trajectory, name);
}

}  // namespace driftwise::application
