#include "server/application/trajectories/pace.h"

#include <algorithm>

namespace driftwise::application {

double guessed_point_s(const RunRules& rules) {
  constexpr double kMove_s = 2.0, kReading_s = 1.0;
  return kMove_s + rules.settle_s + kReading_s * rules.readings_per_point;
}

void Pace::add(double point_s) {
  last_s_.push_back(point_s);
  sum_s_ += point_s;
  if (last_s_.size() > kWindow) {
    sum_s_ -= last_s_.front();
    last_s_.pop_front();
  }
}

double Pace::point_s() const {
  return last_s_.empty() ? guess_s_ : sum_s_ / static_cast<double>(last_s_.size());
}

PlanLength::PlanLength(const Trajectory& trajectory)
    : dwell_s_(trajectory.points.size() + 1),
      returns_(trajectory.points.size() + 1),
      own_dwell_s_(trajectory.points.size()) {
  const auto& points = trajectory.points;
  // Backwards: what stands at a row counts it and all after it.
  bool line_has_zero = false, due = false;
  for (std::size_t row = points.size(); row-- > 0;) {
    const bool ends_line = row + 1 == points.size() || points[row + 1].line != points[row].line;
    if (ends_line) {
      line_has_zero = false;
      due = row + 1 == points.size() || !points[row + 1].zero;
    }
    line_has_zero = line_has_zero || points[row].zero;
    const bool begins_line = row == 0 || points[row - 1].line != points[row].line;
    own_dwell_s_[row] = points[row].dwell_s.value_or(0);
    dwell_s_[row] = dwell_s_[row + 1] + own_dwell_s_[row];
    returns_[row] = returns_[row + 1];
    if (begins_line && due && !line_has_zero) ++returns_[row];
  }
}

double PlanLength::seconds(const Place& place, double point_s) const {
  const auto rows = static_cast<std::int64_t>(own_dwell_s_.size());
  const auto next = static_cast<std::size_t>(std::clamp<std::int64_t>(place.next_row, 0, rows));
  double visits =
      static_cast<double>(own_dwell_s_.size() - next) + static_cast<double>(returns_[next]);
  double dwell_s = dwell_s_[next];
  for (const auto& queued : place.requeued) {
    visits += 1;
    if (queued.row >= 0 && queued.row < rows)
      dwell_s += own_dwell_s_[static_cast<std::size_t>(queued.row)];
  }
  return visits * point_s + dwell_s;
}

}  // namespace driftwise::application
