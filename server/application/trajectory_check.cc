#include "server/application/trajectory_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "server/application/pace.h"
#include "server/formats/trajectory_csv.h"

namespace driftwise::application {
namespace {

struct Bounds {
  Channel channel;
  double min_mm, max_mm;
  std::string axis;
};

Result<std::vector<Bounds>> bounds_of(const CellDescription& description,
                                      const Trajectory& trajectory) {
  std::vector<Bounds> axes;
  for (const auto& device : description.devices)
    for (const auto& axis : device.axes)
      axes.push_back({axis.channel, axis.min_mm, axis.max_mm, axis.device_axis});
  if (axes.size() != trajectory.coordinates.size())
    return fail(ErrorCode::invalid_argument, "WRONG_COORDINATES",
                fmt::format("the trajectory has {} coordinates, the cell {} axes",
                            trajectory.coordinates.size(), axes.size()));
  std::vector<Bounds> bounds;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto& channel = trajectory.coordinates[i];
    auto found = std::ranges::find(axes, channel, &Bounds::channel);
    const bool is_pose = found == axes.end() && is_pose_symbol(channel.symbol);
    if (is_pose) found = axes.begin() + static_cast<std::ptrdiff_t>(i);
    if (found == axes.end())
      return fail(ErrorCode::invalid_argument, "WRONG_COORDINATES",
                  fmt::format("column {}: no axis of cell '{}' has that name, its axes are {} ...",
                              channel.name(), description.name, axes.front().channel.name()));
    bounds.push_back({channel, found->min_mm, found->max_mm, found->axis});
  }
  return bounds;
}

Result<void> check_limits(const std::vector<Bounds>& bounds, const Trajectory& trajectory,
                          const std::string& name) {
  std::size_t outside = 0;
  std::string first;
  for (std::size_t row = 0; row < trajectory.points.size(); ++row)
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      const double value = trajectory.points[row].target_mm[i];
      if (value >= bounds[i].min_mm && value <= bounds[i].max_mm) continue;
      if (outside++ == 0)
        first = fmt::format(
            "{}: row {}: {} = {} mm, the soft limits of axis {} are {:g} to {:g} mm", name, row + 1,
            bounds[i].channel.name(), value, bounds[i].axis, bounds[i].min_mm, bounds[i].max_mm);
    }
  if (outside == 0) return {};
  if (outside > 1) first += fmt::format(" (and {} more values outside)", outside - 1);
  return fail(ErrorCode::out_of_range, "SOFT_LIMIT", first);
}

void add_warnings(TrajectoryCheck& check) {
  const auto& points = check.trajectory.points;
  std::size_t repeated = 0, first_repeated = 0;
  for (std::size_t row = 1; row < points.size(); ++row)
    if (points[row].target_mm == points[row - 1].target_mm && !points[row].zero && repeated++ == 0)
      first_repeated = row + 1;
  if (repeated > 0)
    check.warnings.push_back(fmt::format(
        "{} rows repeat the position of the row before (the first is row {}): they are not "
        "approached anew",
        repeated, first_repeated));
  if (check.validation == 0)
    check.warnings.push_back("no validation rows: the accuracy will be known by calibration only");
  if (check.calibration == 0)
    check.warnings.push_back("no calibration rows: nothing can be fitted to this run alone");
  if (check.zeros == 0)
    check.warnings.push_back(
        "no returns to zero: the axis returns after each line by itself, and these take no row of "
        "the data");
  if (std::ranges::any_of(points, [](const auto& p) { return p.force_n && *p.force_n != 0; }))
    check.warnings.push_back("force_N is recorded, not applied: this cell has no actuator for it");
}

}  // namespace

Result<TrajectoryCheck> check_trajectory_text(const CellDescription& description,
                                              const std::string& name, const std::string& text) {
  auto trajectory = formats::read_trajectory_csv(text, name);
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto bounds = bounds_of(description, *trajectory);
  if (!bounds) return tl::unexpected(bounds.error());
  if (auto ok = check_limits(*bounds, *trajectory, name); !ok) return tl::unexpected(ok.error());
  TrajectoryCheck check;
  std::set<std::int64_t> lines;
  for (const auto& point : trajectory->points) {
    (point.set == PointSet::calibration ? check.calibration : check.validation)++;
    if (point.zero) ++check.zeros;
    lines.insert(point.line);
    check.estimated_s += guessed_point_s(description.run) + point.dwell_s.value_or(0);
  }
  check.lines = static_cast<std::int64_t>(lines.size());
  check.trajectory = std::move(*trajectory);
  add_warnings(check);
  return check;
}

}  // namespace driftwise::application
