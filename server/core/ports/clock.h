#pragma once

#include "server/core/cell_time.h"
#include "server/core/ports/awaitable.h"

namespace driftwise {

// The cell's clock. now() and wall_from() may be called on any thread, the waits on the executor's.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Stamp now() const = 0;
  virtual double speed() const = 0;  // present cell seconds per wall second
  // Resumes at or after the instant; a cancelled wait returns early, and the caller looks at its
  // own flag.
  virtual Awaitable<void> sleep_until(CellTime instant) = 0;
  // How long a duration of cell time takes on the wall at the present speed, but never below the
  // floor (250 ms for I/O time-outs).
  virtual std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                             std::chrono::nanoseconds floor) const = 0;
  // Tells the clock how late the cell's owner runs. While the lag exceeds 1 s of cell time a clock
  // of speed > 1 slows down; it recovers its nominal speed afterwards.
  virtual void report_lag(Nanoseconds lag) = 0;

  Awaitable<void> sleep_for(Nanoseconds duration) { return sleep_until(now().utc + duration); }
};

}  // namespace driftwise
