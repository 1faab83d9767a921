#pragma once
// Cell time for the simulated cell: cell = anchor_cell + (wall - anchor_wall) * speed, wall =
// CLOCK_REALTIME in ns.
//
// At speed 1 and without a file cell time is wall time. Otherwise the anchor lies in a file of 40
// bytes that both processes map: char magic[8] = "DWCLOCK1", u64 sequence (odd while being written;
// a reader tries again), i64 anchor_wall_ns, i64 anchor_cell_ns, f64 speed; all little-endian. The
// simulated cell creates it, the daemon alone rewrites it later; a wait computed from the speed may
// therefore turn out wrong and must be looked at again. Own implementation: the plant's side shares
// no code with the daemon. One thread.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class SimClock {
 public:
  // Wall time is cell time.
  SimClock() = default;
  // Maps the file; creates it first when it is not there: from now on cell time runs from `epoch`
  // (0: the present wall time) at `speed`. Throws SetupError: cannot be created, read or is no
  // clock file.
  SimClock(const std::filesystem::path& file, TimeNs epoch, double speed);
  ~SimClock();
  SimClock(const SimClock&) = delete;
  SimClock& operator=(const SimClock&) = delete;

  TimeNs now();  // never runs back
  double speed() const;
  // How long to wait on the wall for the instant at the present speed; 0 when it has passed.
  std::chrono::nanoseconds wall_until(TimeNs instant);
  // Whether somebody else may change the speed while we wait.
  bool shared() const { return mapped_ != nullptr; }

  static TimeNs wall_now();

 private:
  struct Anchor {
    std::int64_t wall_ns = 0, cell_ns = 0;
    double speed = 1;
  };
  Anchor anchor() const;

  const void* mapped_ = nullptr;
  TimeNs last_ = INT64_MIN;
};

}  // namespace driftwise::simulated
