#pragma once
// How cell time was tied to UTC, as the database keeps it. As server/core/ports/store.h: calls
// block, one thread.

#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/result.h"

namespace driftwise {

// One start of the daemon, or one step of the wall clock.
struct ClockRecord {
  CellTime from;  // from here on UTC is cell time plus the offset
  Nanoseconds offset{0};
  Nanoseconds step{0};        // of the wall clock; 0: a start without one
  std::string boot;           // names the computer's start; empty: not known
  std::int64_t boot_ns = 0;   // time since that start at `from`, suspend included
  std::int64_t ahead_ns = 0;  // the wall clock minus boot_ns at `from`
};

class ClockStore {
 public:
  virtual ~ClockStore() = default;
  virtual Result<void> add_clock(const ClockRecord& record) = 0;
  virtual Result<std::vector<ClockRecord>> clocks() = 0;  // oldest first
  // The newest instant of a reading, an event or a clock record; utc_ns 0: an empty database.
  virtual Result<CellTime> newest_instant() = 0;
};

}  // namespace driftwise
