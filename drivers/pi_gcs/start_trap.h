#pragma once

#include "server/core/cell_time.h"

namespace driftwise::gcs {

// A controller may start to move a while after it has accepted MOV, and says "not moving" and even
// "on target" (of the old target) until then. A move counts as under way until motion has been seen
// or that while has passed.
class StartTrap {
 public:
  explicit StartTrap(Nanoseconds start_delay) : start_delay_(start_delay) {}

  void commanded(CellTime accepted) {
    armed_ = true;
    accepted_ = accepted;
  }
  void disarm() { armed_ = false; }

  // moving: what the controller answered to a question asked at `asked`.
  bool under_way(bool moving, CellTime asked) {
    if (moving || asked - accepted_ >= start_delay_) armed_ = false;
    return moving || armed_;
  }

 private:
  Nanoseconds start_delay_;
  bool armed_ = false;
  CellTime accepted_;
};

}  // namespace driftwise::gcs
