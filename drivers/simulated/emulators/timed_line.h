#pragma once
// The line to one client, as one wire: what was asked for first leaves first, and a byte on RS-232
// takes its time.

#include <algorithm>
#include <cstddef>

#include "drivers/simulated/emulators/emulator.h"

namespace driftwise::simulated {

constexpr double kBitsPerByte = 10;  // start, eight, stop

class TimedLine {
 public:
  explicit TimedLine(Link link = Link::tcp) : link_(link) {}

  // When the last of the bytes is out that are ready at `ready`. baud 0: bytes take no time.
  TimeNs carry(std::size_t bytes, double baud, TimeNs ready) {
    const bool takes_time = link_ == Link::serial && baud > 0;
    const double wire_s = takes_time ? kBitsPerByte * static_cast<double>(bytes) / baud : 0.0;
    free_at_ = std::max(ready, free_at_) + nanoseconds_from(wire_s);
    return free_at_;
  }

 private:
  Link link_;
  TimeNs free_at_ = 0;  // when it has carried what was said before
};

}  // namespace driftwise::simulated
