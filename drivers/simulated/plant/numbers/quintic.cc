#include "drivers/simulated/plant/numbers/quintic.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {

Quintic::Quintic(double start_s, const Kinematics& from, double end_mm, double duration_s)
    : start_s_(start_s), duration_s_(duration_s), end_mm_(end_mm) {
  const double v = from.mm_s * duration_s;
  const double a = from.mm_s2 * duration_s * duration_s;
  const double d = end_mm - from.mm;
  c_[0] = from.mm;
  c_[1] = v;
  c_[2] = a / 2;
  c_[3] = 10 * d - 6 * v - 1.5 * a;
  c_[4] = -15 * d + 8 * v + 1.5 * a;
  c_[5] = 6 * d - 3 * v - 0.5 * a;
}

Kinematics Quintic::at(double time_s) const {
  const double u = (time_s - start_s_) / duration_s_;
  if (u >= 1) return {.mm = end_mm_};
  if (u <= 0) return {.mm = c_[0], .mm_s = c_[1] / duration_s_};
  const double p = c_[0] + u * (c_[1] + u * (c_[2] + u * (c_[3] + u * (c_[4] + u * c_[5]))));
  const double v = c_[1] + u * (2 * c_[2] + u * (3 * c_[3] + u * (4 * c_[4] + u * 5 * c_[5])));
  const double a = 2 * c_[2] + u * (6 * c_[3] + u * (12 * c_[4] + u * 20 * c_[5]));
  return {.mm = p, .mm_s = v / duration_s_, .mm_s2 = a / (duration_s_ * duration_s_)};
}

double quintic_duration_s(double distance_mm, double velocity_mm_s, double acceleration_mm_s2) {
  constexpr double kShortest_s = 0.05;
  const double by_velocity_s = 15.0 / 8.0 * distance_mm / velocity_mm_s;
  const double by_acceleration_s =
      std::sqrt(10 / std::sqrt(3.0) * distance_mm / acceleration_mm_s2);
  return std::max({kShortest_s, by_velocity_s, by_acceleration_s});
}

}  // namespace driftwise::simulated
