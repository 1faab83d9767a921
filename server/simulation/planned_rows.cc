#include "server/simulation/planned_rows.h"

#include <algorithm>
#include <cmath>

#include "server/core/try.h"
#include "server/simulation/forward_model.h"

namespace driftwise::simulation {
namespace {

// Columns of the rows to come: motor coordinates, pose, force, conditions. Where each is.
struct PlannedTable {
  Dataset rows;
  std::vector<std::string> symbols;
  std::size_t add(const Channel& channel) {
    for (std::size_t i = 0; i < symbols.size(); ++i)
      if (symbols[i] == channel.symbol) return i;
    symbols.push_back(channel.symbol);
    rows.columns.push_back({channel, {}});
    return symbols.size() - 1;
  }
};

}  // namespace

PointTimes point_times(const Trajectory& trajectory, const MotionTimes& times) {
  PointTimes out;
  std::vector<double> at(trajectory.coordinates.size(), 0.0);
  double now_s = 0;
  std::optional<double> force_n;
  for (const auto& point : trajectory.points) {
    if (point.force_n && (!force_n || *point.force_n != *force_n)) {
      if (force_n) now_s += times.load_s;
      force_n = point.force_n;
    }
    double longest_s = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      const bool turns = trajectory.coordinates[k].unit == "arcsec";
      const double velocity = turns ? times.velocity_arcsec_s : times.velocity_mm_s;
      longest_s = std::max(longest_s, std::abs(point.target[k] - at[k]) / velocity);
    }
    at = point.target;
    now_s += longest_s;
    const double waited_s = times.settle_s + point.dwell_s.value_or(0) + times.reading_s / 2;
    out.time_s.push_back(now_s + waited_s);
    out.dwell_s.push_back(waited_s);
    now_s += waited_s + times.reading_s / 2;
  }
  out.total_s = now_s;
  return out;
}

Result<Dataset> planned_rows(const calibration::Model& model, const Trajectory& trajectory,
                             const std::vector<std::pair<Channel, double>>& conditions,
                             const MotionTimes& times, double start_s) {
  PlannedTable table;
  std::vector<std::size_t> motors;
  for (const auto& channel : trajectory.coordinates) motors.push_back(table.add(channel));
  std::vector<double> values(motors.size(), 0.0);
  for (const auto& range : model.domain) {
    if (!is_pose_symbol(range.channel.symbol)) continue;
    table.add(range.channel);
    values.push_back(kMissing);  // the first guess: the middle of the domain
  }
  for (const auto& [channel, value] : conditions) {
    const auto column = table.add(channel);
    values.resize(table.symbols.size(), kMissing);
    if (!is_pose_symbol(channel.symbol) || channel.unit != "mm") values[column] = value;
  }
  const bool forced = std::ranges::any_of(
      trajectory.points, [](const auto& point) { return point.force_n.has_value(); });
  const std::size_t force = forced ? table.add({"force", "N"}) : 0;
  values.resize(table.symbols.size(), kMissing);
  DRIFTWISE_TRY(auto forward, ForwardModel::create(model, table.symbols));
  std::vector<std::size_t> solved;
  for (const auto& symbol : forward.pose_symbols()) {
    const auto at = std::ranges::find(table.symbols, symbol);
    solved.push_back(static_cast<std::size_t>(at - table.symbols.begin()));
  }

  const PointTimes when = point_times(trajectory, times);
  Dataset& rows = table.rows;
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const auto& point = trajectory.points[i];
    for (std::size_t k = 0; k < motors.size(); ++k) values[motors[k]] = point.target[k];
    if (forced && point.force_n) values[force] = *point.force_n;
    std::vector<double> wanted;
    for (const auto& symbol : forward.motor_symbols()) {
      const auto at = std::ranges::find(table.symbols, symbol);
      wanted.push_back(at == table.symbols.end()
                           ? kMissing
                           : values[static_cast<std::size_t>(at - table.symbols.begin())]);
    }
    const double time_s = start_s + when.time_s[i];
    DRIFTWISE_TRY(const auto pose, forward.step(time_s, wanted, values));
    for (std::size_t k = 0; k < solved.size(); ++k)
      values[solved[k]] = pose[static_cast<Eigen::Index>(k)];
    rows.time_s.push_back(time_s);
    rows.dwell_s.push_back(when.dwell_s[i]);
    rows.set.push_back(point.set);
    rows.line.push_back(point.line);
    rows.zero.push_back(point.zero ? 1 : 0);
    for (std::size_t c = 0; c < values.size(); ++c) rows.columns[c].values.push_back(values[c]);
  }
  rows.rows = rows.time_s.size();
  return std::move(table.rows);
}

}  // namespace driftwise::simulation
