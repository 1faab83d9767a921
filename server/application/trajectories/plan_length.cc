#include "server/application/trajectories/plan_length.h"

#include <algorithm>

namespace driftwise::application {

double planned_visit_s(const RunRules& rules) {
  constexpr double kMove_s = 2.0, kReading_s = 1.0;
  return kMove_s + rules.settle_s + kReading_s * rules.readings_per_point;
}

PlanLength::PlanLength(const Trajectory& trajectory)
    : dwell_s_(trajectory.points.size() + 1), returns_(trajectory.points.size() + 1) {
  const auto& points = trajectory.points;
  // Backwards: what stands at a row counts it and all after it.
  bool due = false;
  std::size_t end = 0;  // of the line under way
  for (std::size_t row = points.size(); row-- > 0;) {
    const bool ends_line = row + 1 == points.size() || points[row + 1].line != points[row].line;
    if (ends_line) {
      end = row;
      due = row + 1 == points.size() || !points[row + 1].zero;
      for (std::size_t of_line = row + 1; due && of_line-- > 0;) {
        if (points[of_line].line != points[row].line) break;
        due = !points[of_line].zero;
      }
    }
    dwell_s_[row] = dwell_s_[row + 1] + points[row].dwell_s.value_or(0);
    returns_[row] = returns_[row + 1] + (row == end && due ? 1 : 0);
  }
}

PlanAhead PlanLength::row(std::int64_t row) const {
  const auto rows = static_cast<std::int64_t>(returns_.size()) - 1;
  if (row < 0 || row >= rows) return {1, 0};
  const auto at = static_cast<std::size_t>(row);
  return {1 + static_cast<double>(returns_[at] - returns_[at + 1]),
          dwell_s_[at] - dwell_s_[at + 1]};
}

PlanAhead PlanLength::ahead(const Place& place) const {
  const auto rows = static_cast<std::int64_t>(returns_.size()) - 1;
  const auto next = std::clamp<std::int64_t>(place.next_row, 0, rows);
  const auto at = static_cast<std::size_t>(next);
  PlanAhead ahead{static_cast<double>(rows - next) + static_cast<double>(returns_[at]),
                  dwell_s_[at]};
  for (const auto& queued : place.requeued) {
    ahead.visits += 1;
    ahead.dwell_s += row(queued.row).dwell_s;
  }
  return ahead;
}

}  // namespace driftwise::application
