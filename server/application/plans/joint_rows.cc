#include "server/application/plans/joint_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/trajectories/trajectory_limits.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/plans/joint_target.h"

namespace driftwise::application {
namespace {

Result<void> check_every_robot_is_named(const plans::JointSnapshot& plan,
                                        const std::vector<Channel>& coordinates) {
  for (const auto& robot : plan.robots)
    if (std::ranges::none_of(coordinates, [&robot](const Channel& coordinate) {
          return robot_of(coordinate.symbol) == robot.id;
        }))
      return fail(ErrorCode::invalid_argument, reasons::kMissingCoordinate,
                  fmt::format("plan {} moves the robot '{}' too: state its pose in columns {}.x_mm "
                              "... or {}.rx_arcsec ..., 0 included",
                              plan.plan.value, robot.id, robot.id, robot.id));
  return {};
}

// The motor coordinate's place among the axes of the cell; their number when it has no such axis.
std::size_t axis_of(const std::vector<Channel>& motors, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(motors, name, &Channel::name) - motors.begin());
}

}  // namespace

Result<RowCommand> joint_row(const CellDescription& cell, const plans::JointSnapshot& plan,
                             const std::vector<Channel>& coordinates, const TrajectoryPoint& row,
                             CellTime now) {
  DRIFTWISE_RETURN_IF_ERROR(check_every_robot_is_named(plan, coordinates));
  plans::JointRequest request;
  request.now = now;
  request.with_uncertainty = false;
  request.show_unreachable = true;  // whoever moves there checks the limits, and names the row
  std::vector<plans::JointName> places;
  if (!plan.robots.empty())
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      DRIFTWISE_TRY(const auto place, plans::joint_name(plan, coordinates[i].name()));
      request.set(place.robot, place.variable, row.target[i]);
      places.push_back(place);
    }
  if (row.force_n)
    request.set(plans::JointRequest::kNoRobot, compensation::Variable::force, *row.force_n);
  const auto target = plans::compute_joint_target(plan, request);
  if (target.refusal != compensation::Refusal::none)
    return tl::unexpected(plans::joint_refusal_error(plan, target));

  const auto motors = cell.motor_channels();
  RowCommand command{std::vector<double>(motors.size(), 0.0), row.target};
  std::vector<bool> given(motors.size(), false);
  for (std::size_t output = 0; output < target.outputs; ++output) {
    const auto axis = axis_of(motors, plans::joint_channel(plan, target, output));
    if (axis == motors.size()) continue;
    command.q_mm[axis] = target.q_mm[output];
    given[axis] = true;
  }
  for (std::size_t axis = 0; axis < motors.size(); ++axis)
    if (!given[axis] && plan.robot_index(robot_of(motors[axis].symbol)))
      return fail(ErrorCode::failed_precondition, reasons::kNotAllAxes,
                  fmt::format("plan {} gives no {}: fit all motor coordinates of robot '{}'",
                              plan.plan.value, motors[axis].name(), robot_of(motors[axis].symbol)));
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i].robot < target.robots)
      command.target[i] =
          target.robot[places[i].robot].pose[static_cast<std::size_t>(places[i].variable)];
  return command;
}

Result<void> check_joint_rows(const CellDescription& cell, const plans::JointSnapshot& plan,
                              const Trajectory& trajectory, const std::string& name, CellTime now) {
  Trajectory motors;
  motors.coordinates = cell.motor_channels();
  for (std::size_t row = 0; row < trajectory.points.size(); ++row) {
    auto& point = motors.points.emplace_back(trajectory.points[row]);
    auto command = joint_row(cell, plan, trajectory.coordinates, trajectory.points[row], now);
    if (!command)
      return fail(command.error().code, command.error().reason,
                  fmt::format("{}: row {}: {}", name, row + 1, command.error().message));
    point.target = std::move(command->q_mm);
  }
  DRIFTWISE_RETURN_IF_ERROR(check_trajectory_limits(cell, motors, name));
  return check_trajectory_keep_out(cell, motors, name);
}

}  // namespace driftwise::application
