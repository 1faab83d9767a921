#include "server/application/trajectories/trajectory_check.h"

#include <fmt/format.h>

#include <set>

#include "server/application/motion/loading.h"
#include "server/application/trajectories/motor_rows.h"
#include "server/application/trajectories/trajectory_confounding.h"
#include "server/application/trajectories/trajectory_limits.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::application {
namespace {

void add_warnings(TrajectoryCheck& check) {
  const auto& points = check.trajectory.points;
  std::size_t repeated = 0, first_repeated = 0;
  for (std::size_t row = 1; row < points.size(); ++row)
    if (points[row].target == points[row - 1].target && !points[row].zero && repeated++ == 0)
      first_repeated = row + 1;
  if (repeated > 0)
    check.warnings.push_back(
        fmt::format("{} the position of the row before{}: not approached anew",
                    repeated == 1 ? fmt::format("row {} repeats", first_repeated)
                                  : fmt::format("{} rows repeat", repeated),
                    repeated == 1 ? "" : fmt::format(" (the first is row {})", first_repeated)));
  if (check.validation == 0)
    check.warnings.push_back("no validation rows: the accuracy will be known by calibration only");
  if (check.calibration == 0)
    check.warnings.push_back("no calibration rows: nothing can be fitted to this run alone");
  if (check.zeros == 0)
    check.warnings.push_back(
        "no returns to zero: the axis returns after each line by itself; each such return is a "
        "passage in the data and in no fit");
}

// What a fit could not tell apart afterwards.
void add_confoundings(TrajectoryCheck& check, const std::vector<double>& time_s) {
  constexpr std::size_t kMostNamed = 4;
  if (const auto trend = force_trend(check.trajectory, time_s); trend.confounded())
    check.warnings.push_back("confounded: " + trend.sentence());
  auto alike = look_alikes(check.trajectory);
  if (alike.size() > kMostNamed) {
    const auto more = alike.size() - kMostNamed;
    alike.resize(kMostNamed);
    alike.push_back(fmt::format("... and {} more terms of position likewise", more));
  }
  check.warnings.insert(check.warnings.end(), alike.begin(), alike.end());
}

Result<void> check_forces(const CellDescription& description, const Trajectory& trajectory,
                          const std::string& name) {
  for (std::size_t row = 0; row < trajectory.points.size(); ++row) {
    const auto& force_n = trajectory.points[row].force_n;
    // A plan of forces that are all 0 asks nothing of a cell that knows none.
    if (!force_n || (!description.load && *force_n == 0)) continue;
    if (const auto ok = check_force(description, *force_n); !ok)
      return fail(ok.error().code, ok.error().reason,
                  fmt::format("{}: row {}: {}", name, row + 1, ok.error().message));
  }
  return {};
}

}  // namespace

Result<TrajectoryCheck> check_trajectory_text(const CellDescription& description,
                                              const std::string& name, const std::string& text,
                                              const DurationHistory& history) {
  DRIFTWISE_TRY(auto trajectory, formats::read_trajectory_csv(text, name));
  DRIFTWISE_TRY(const auto limits, check_trajectory_limits(description, trajectory, name));
  DRIFTWISE_RETURN_IF_ERROR(check_trajectory_keep_out(description, trajectory, name));
  DRIFTWISE_RETURN_IF_ERROR(check_forces(description, trajectory, name));
  const double unit_s = planned_visit_s(description.run);
  const double visit_s = unit_s * history.level();
  TrajectoryCheck check;
  std::vector<double> time_s;
  std::set<std::int64_t> lines;
  for (const auto& point : trajectory.points) {
    (point.set == PointSet::calibration ? check.calibration : check.validation)++;
    if (point.zero) ++check.zeros;
    lines.insert(point.line);
    time_s.push_back((time_s.empty() ? 0 : time_s.back()) + visit_s + point.dwell_s.value_or(0));
  }
  check.plan = PlanLength(trajectory).ahead({});
  RunAhead whole;
  whole.plan = check.plan;
  whole.unit_s = unit_s;
  check.outlook = look_ahead(history, whole);
  check.estimated_s = check.outlook.expected_s;
  check.lines = static_cast<std::int64_t>(lines.size());
  check.trajectory = std::move(trajectory);
  add_warnings(check);
  if (!limits.empty()) check.warnings.push_back(limits);
  if (!description.keep_outs.empty() &&
      !is_motor_symbol(without_robot(check.trajectory.coordinates.front().symbol)))
    check.warnings.push_back(
        "whether the robots keep their distance at these poses is checked when the run begins, and "
        "at each move");
  add_confoundings(check, time_s);
  return check;
}

}  // namespace driftwise::application
