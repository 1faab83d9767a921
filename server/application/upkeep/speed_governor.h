#pragma once
// Decides how fast cell time may run: gives way when the cell's owner falls behind, recovers
// slowly. Pure.

#include <chrono>
#include <cstdint>
#include <optional>

#include "server/core/cell_time.h"

namespace driftwise::application {

class SpeedGovernor {
 public:
  static constexpr double kLagLimit_s = 1.0;     // cell seconds; the contract's figure
  static constexpr double kComfortable_s = 0.3;  // below this the speed may grow again
  static constexpr std::chrono::milliseconds kBetweenSlowdowns{
      100};  // wall: let the last one show its effect
  static constexpr std::chrono::milliseconds kBetweenRecoveries{2000};

  explicit SpeedGovernor(double nominal) : nominal_(nominal), present_(nominal) {}

  // lag in cell time, at_wall_ns monotonic in wall time. The new speed when it changes: halved
  // while the lag exceeds the limit (never below 1), a quarter more of what it is after two
  // comfortable seconds, until nominal.
  std::optional<double> report(Nanoseconds lag, std::int64_t at_wall_ns);
  double present() const { return present_; }

 private:
  double nominal_, present_;
  std::int64_t last_change_ns_ = 0, last_uncomfortable_ns_ = 0;
};

}  // namespace driftwise::application
