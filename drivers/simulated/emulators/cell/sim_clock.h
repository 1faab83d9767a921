#pragma once
// Cell time for the simulated cell: cell = anchor_cell + (boot - anchor_boot) * speed, boot =
// CLOCK_BOOTTIME in ns: the time since the computer's start, which nobody sets.
//
// At speed 1 and without a file cell time begins as UTC. Otherwise the anchor lies in a file of 64
// bytes that both processes map: char magic[8] = "DWCLOCK2", u64 sequence (odd while being written;
// a reader tries again), i64 anchor_boot_ns, i64 anchor_cell_ns, f64 speed, i64 anchor_wall_ns, u8
// boot[16] (which start of the computer); all little-endian. The simulated cell creates it, the
// daemon alone rewrites it while it runs; a wait computed from the speed may therefore turn out
// wrong and must be looked at again. Own implementation: the plant's side shares no code with the
// daemon. One thread.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class SimClock {
 public:
  // Cell time begins as UTC.
  SimClock() : own_{boot_now(), wall_now(), 1} {}
  // Maps the file; creates it first when it is not there: from now on cell time runs from `epoch`
  // (0: the present UTC) at `speed`. A file of an earlier start of the computer is made anew, and
  // its time goes on by the wall clock. Throws SetupError: cannot be created, read or is no clock
  // file.
  SimClock(const std::filesystem::path& file, TimeNs epoch, double speed);
  ~SimClock();
  SimClock(const SimClock&) = delete;
  SimClock& operator=(const SimClock&) = delete;

  TimeNs now();  // never runs back
  double speed() const;
  // How long to wait on the wall for the instant at the present speed; 0 when it has passed.
  std::chrono::nanoseconds wall_until(TimeNs instant);
  // Sets cell time forward to an instant, at the present speed; an instant that has passed changes
  // nothing. The file is made anew: a process that has mapped the old one does not see it, so none
  // may run. Throws SetupError: cannot be written.
  void set_forward(TimeNs instant);
  // Whether somebody else may change the speed while we wait.
  bool shared() const { return mapped_ != nullptr; }

  static TimeNs wall_now();

 private:
  struct Anchor {
    std::int64_t boot_ns = 0, cell_ns = 0;
    double speed = 1;
    std::int64_t wall_ns = 0;
  };
  static TimeNs boot_now();
  void map(const std::filesystem::path& file);
  Anchor anchor() const;
  Anchor own_;  // without a file
  std::filesystem::path file_;

  const void* mapped_ = nullptr;
  TimeNs last_ = INT64_MIN;
};

}  // namespace driftwise::simulated
