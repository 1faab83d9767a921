#include "server/application/pace.h"

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

CellTime Pace::estimated_end(CellTime now, std::int64_t visits_left) const {
  return now + nanoseconds_from_s(point_s() * static_cast<double>(visits_left));
}

}  // namespace driftwise::application
