#pragma once
// The computer's clocks. Time since its start runs on through a suspend and is never set
// (CLOCK_BOOTTIME); the wall clock may be set at any time (CLOCK_REALTIME). A test puts functions
// of its own here.

#include <cstdint>
#include <functional>
#include <string>

namespace driftwise::application {

struct ComputerClock {
  std::function<std::int64_t()> boot_ns;  // since the computer's start
  std::function<std::int64_t()> wall_ns;  // UTC since 1970
  std::string boot;                       // names this start of the computer; empty: not known
};

// /proc/sys/kernel/random/boot_id names the start.
ComputerClock this_computer();

// The wall clock minus the time since the start, free of the time between the two readings: the
// narrowest of a few bracketed comparisons.
std::int64_t wall_ahead_ns(const ComputerClock& computer);

}  // namespace driftwise::application
