#pragma once

#include <algorithm>
#include <optional>

#include "server/core/cell_time.h"

namespace driftwise::transport {

// Measured offset of a device's own clock to cell time, for a device that stamps its answers with
// instants.
//
// Every exchange proves an interval: what the device stamped happened after the question and before
// its answer. The estimate stays where the newest interval holds it and moves to the nearest bound
// otherwise, so that it follows a slow drift. A distance to the interval that no drift explains is
// a jump: the device's clock was set.
class DeviceClock {
 public:
  static constexpr double kJump_s = 0.1;        // above the tolerance of any exchange
  static constexpr double kFollows_s = 0.05;    // of real time, at a speed above 1
  static constexpr double kDrift_per_s = 1e-3;  // a thousand times that of a quartz

  // first, last: the device's stamps of the earliest and the latest event within (asked, answered).
  // speed: cell seconds per real second. A simulated cell follows a change of it some milliseconds
  // of real time later. Result: by how much the device's clock has jumped; none: it has not, or
  // nothing was known.
  std::optional<Nanoseconds> observe(CellTime first, CellTime last, CellTime asked,
                                     CellTime answered, double speed = 1) {
    const Nanoseconds most = first - asked, least = std::min(last - answered, most);
    if (!offset_) {
      offset_ = least;
      seen_ = answered;
      return std::nullopt;
    }
    const Nanoseconds before = *offset_;
    offset_ = std::clamp(before, least, most);
    const auto limit =
        nanoseconds_from_s(kJump_s + (speed > 1 ? kFollows_s * speed : 0) +
                           kDrift_per_s * std::max(0.0, seconds_from(answered - seen_)));
    seen_ = answered;
    const Nanoseconds moved = *offset_ - before;
    if (moved <= limit && moved >= -limit) return std::nullopt;
    return moved;
  }

  CellTime cell_time(CellTime device_stamp) const {
    return device_stamp - offset_.value_or(Nanoseconds(0));
  }
  // Device minus cell time; none: nothing observed yet.
  const std::optional<Nanoseconds>& offset() const { return offset_; }

 private:
  std::optional<Nanoseconds> offset_;
  CellTime seen_;
};

}  // namespace driftwise::transport
