#pragma once

#include <algorithm>
#include <optional>

#include "server/core/cell_time.h"

namespace driftwise::transport {

// Ties a device's own running clock (seconds since whatever) to cell time.
//
// Every exchange proves an interval: what the device stamped happened after we asked and before its
// answer arrived. The anchor keeps its estimate as long as it lies within the newest interval and
// moves to the nearest bound when not: it tightens while the delays vary, follows a slow drift of
// the device's clock, and starts anew when that clock is reset.
class ClockAnchor {
 public:
  // first_s, last_s: the device's stamps of the earliest and latest event within (asked, answered).
  void observe(double first_s, double last_s, CellTime asked, CellTime answered) {
    const CellTime earliest = asked - nanoseconds_from_s(first_s);
    const CellTime latest = std::max(answered - nanoseconds_from_s(last_s), earliest);
    const bool reset = zero_ && last_s < newest_s_;
    newest_s_ = last_s;
    zero_ = zero_ && !reset ? std::clamp(*zero_, earliest, latest) : latest;
  }
  CellTime cell_time(double device_s) const {
    return zero_.value_or(CellTime{}) + nanoseconds_from_s(device_s);
  }
  void forget() { zero_.reset(); }

 private:
  std::optional<CellTime> zero_;  // cell time at the device's second 0
  double newest_s_ = 0;
};

}  // namespace driftwise::transport
