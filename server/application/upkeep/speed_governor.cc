#include "server/application/upkeep/speed_governor.h"

#include <algorithm>

namespace driftwise::application {

std::optional<double> SpeedGovernor::report(Nanoseconds lag, std::int64_t at_wall_ns) {
  if (nominal_ <= 1) return std::nullopt;  // real time gives way to nobody
  const auto since = [at_wall_ns](std::int64_t then) {
    return std::chrono::nanoseconds(at_wall_ns - then);
  };
  const double lag_s = seconds_from(lag);
  if (lag_s > kComfortable_s) last_uncomfortable_ns_ = at_wall_ns;
  double wanted = present_;
  if (lag_s > kLagLimit_s) {
    if (last_change_ns_ == 0 || since(last_change_ns_) >= kBetweenSlowdowns)
      wanted = std::max(1.0, present_ / 2);
  } else if (present_ < nominal_ && since(last_change_ns_) >= kBetweenRecoveries &&
             since(last_uncomfortable_ns_) >= kBetweenRecoveries) {
    wanted = std::min(nominal_, present_ * 1.25);
  }
  if (wanted == present_) return std::nullopt;
  present_ = wanted;
  last_change_ns_ = at_wall_ns;
  return present_;
}

}  // namespace driftwise::application
