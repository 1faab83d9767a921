#include "server/application/trajectories/motor_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "server/application/motion/keep_out.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

bool are_motors(const std::vector<Channel>& coordinates) {
  return is_motor_symbol(without_robot(coordinates.front().symbol));
}

// Lines that return to zero by a row of their own; after another one the axes do so by themselves.
std::set<std::int64_t> lines_with_zero(const Trajectory& trajectory) {
  std::set<std::int64_t> lines;
  for (const auto& point : trajectory.points)
    if (point.zero) lines.insert(point.line);
  return lines;
}

}  // namespace

AxesToMove axes_moved_by(const CellDescription& cell, const std::vector<Channel>& coordinates) {
  if (!cell.has_several_robots()) return {};
  AxesToMove moved;
  for (const auto& axis : cell.motor_channels())
    moved.named.push_back(std::ranges::any_of(coordinates, [&axis](const Channel& coordinate) {
      return robot_of(coordinate.symbol) == robot_of(axis.symbol);
    }));
  return moved;
}

std::vector<double> motor_row(const CellDescription& cell, const std::vector<Channel>& coordinates,
                              const std::vector<double>& target) {
  if (!are_motors(coordinates)) return target;
  const auto motors = cell.motor_channels();
  std::vector<double> q_mm(motors.size(), 0.0);
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (const auto at = std::ranges::find(motors, coordinates[i]); at != motors.end())
      q_mm[static_cast<std::size_t>(at - motors.begin())] = target[i];
  return q_mm;
}

Result<void> check_trajectory_keep_out(const CellDescription& cell, const Trajectory& trajectory,
                                       const std::string& name) {
  if (cell.keep_outs.empty() || !are_motors(trajectory.coordinates)) return {};
  const auto with_zero = lines_with_zero(trajectory);
  const std::vector<double> zero_mm(cell.motor_channels().size(), 0.0);
  const auto check = [&](const std::vector<double>& from, const std::vector<double>& to,
                         std::size_t row, const char* what) -> Result<void> {
    if (auto good = check_keep_out(cell, from, to); !good)
      return fail(good.error().code, good.error().reason,
                  fmt::format("{}: row {}{}: {}", name, row + 1, what, good.error().message));
    return {};
  };
  const auto& points = trajectory.points;
  auto at_mm = zero_mm;
  for (std::size_t row = 0; row < points.size(); ++row) {
    auto to_mm = motor_row(cell, trajectory.coordinates, points[row].target);
    DRIFTWISE_RETURN_IF_ERROR(check(at_mm, to_mm, row, ""));
    at_mm = std::move(to_mm);
    const bool is_last = row + 1 == points.size();
    const bool ends_line = is_last || points[row + 1].line != points[row].line;
    const bool returns =
        ends_line && !with_zero.contains(points[row].line) && (is_last || !points[row + 1].zero);
    if (!is_last && !returns) continue;
    DRIFTWISE_RETURN_IF_ERROR(check(at_mm, zero_mm, row, ", the return to zero after it"));
    at_mm = zero_mm;
  }
  return {};
}

}  // namespace driftwise::application
