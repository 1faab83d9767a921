#pragma once

#include <atomic>
#include <memory>

#include "server/core/cell_time.h"
#include "server/core/ports/awaitable.h"
#include "server/core/utc_map.h"

namespace driftwise {

// One start of the computer, and the time since it, suspend included.
struct SinceBoot {
  std::string name;  // empty: not known
  std::int64_t ns = 0;
};

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

  // The wall clock, for WallClockWatch alone: everything else lives in cell time. A clock without
  // one answers as below.
  virtual SinceBoot since_boot() const { return {}; }
  virtual std::int64_t wall_ahead_ns() const {
    return 0;
  }  // UTC minus since_boot(): steps when set
  // True: cell time is given by the simulated cell, or by a test, and begin_at() changes nothing.
  virtual bool is_simulated() const { return true; }
  // Cell time is `now` at this instant, or later than not_before. Once, before anybody waits.
  virtual void begin_at(CellTime now, CellTime not_before) {
    static_cast<void>(now), static_cast<void>(not_before);
  }

  Awaitable<void> sleep_for(Nanoseconds duration) { return sleep_until(now().utc + duration); }

  // UTC for people and for the wire, and back; any thread. Kept up to date by WallClockWatch.
  UtcTime utc(CellTime instant) const { return utc_map_.load()->utc(instant); }
  CellTime cell_time(UtcTime utc) const { return utc_map_.load()->cell_time(utc); }
  void map_utc(UtcMap map) { utc_map_.store(std::make_shared<const UtcMap>(std::move(map))); }

 private:
  std::atomic<std::shared_ptr<const UtcMap>> utc_map_{std::make_shared<const UtcMap>()};
};

}  // namespace driftwise
