#include "server/application/trajectories/trajectory_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::application {
namespace {

std::vector<AxisDescription> axes_of(const CellDescription& description) {
  std::vector<AxisDescription> axes;
  for (const auto& device : description.devices)
    axes.insert(axes.end(), device.axes().begin(), device.axes().end());
  return axes;
}

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
      const double mm = trajectory.points[row].target_mm[i];
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
      const double mm = trajectory.points[row].target_mm[i];
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

}  // namespace

Result<std::string> check_trajectory_limits(const CellDescription& description,
                                            const Trajectory& trajectory, const std::string& name) {
  const auto axes = axes_of(description);
  if (axes.size() != trajectory.coordinates.size()) {
    std::string found, expected;
    for (const auto& channel : trajectory.coordinates)
      found += (found.empty() ? "" : ", ") + channel.name();
    for (const auto& axis : axes) expected += (expected.empty() ? "" : ", ") + axis.channel.name();
    return fail(
        ErrorCode::invalid_argument, reasons::kWrongCoordinates,
        fmt::format("{}: found the coordinates {}, expected one for each axis of cell '{}': "
                    "{}, or a pose with as many coordinates",
                    name, found, description.name, expected));
  }
  if (axes.size() > 1 && is_pose_symbol(trajectory.coordinates.front().symbol))
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

}  // namespace driftwise::application
