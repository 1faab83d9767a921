#pragma once
// What asks for a person, from a look at the cell: each condition as an object, so that it can be
// acknowledged by itself. Pure.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/alarm_condition.h"
#include "server/application/runs/run_progress.h"
#include "server/application/status/cell_status.h"

namespace driftwise::application {

// device.lost; device.unused (of no set-up in use: notice); channel.stale; run.waiting, run.paused;
// gate.given_up; daemon.paused, for a minute after a pause of the executor.
std::vector<AlarmCondition> alarm_conditions(const CellStatus& status);

// The quality gate's trend over the last points of a run: before points are given up, their spread
// grows and they need more attempts.
class QualityTrend {
 public:
  static constexpr std::size_t kPoints = 20;
  static constexpr double kManyAttempts = 1.5, kFewAttempts = 1.25;

  void take(const RunProgress& progress);
  // gate.spread: the median spread of the last 20 accepted points is above 80 % of the limit, or
  // they took more than kManyAttempts each. It is over once they took kFewAttempts at most: about
  // one limit it would begin and end with every other point.
  std::optional<AlarmCondition> condition(double max_spread_nm) const;
  // Whether enough points of this run were taken to say so; they are counted from the start on.
  bool has_judged(RunId run) const { return run_ == run && spreads_nm_.size() >= kPoints; }

 private:
  double attempts_each() const;

  RunId run_;
  std::int64_t accepted_ = 0;
  bool many_attempts_ = false;
  std::vector<double> spreads_nm_;      // of the last points, oldest first
  std::vector<std::int64_t> attempts_;  // of the run, when each of them was accepted
  std::int64_t attempts_before_ = 0;    // ... and before the oldest
};

}  // namespace driftwise::application
