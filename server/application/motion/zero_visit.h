#pragma once
// One visit of the zero: moved to and read with the budget of a row, or refused. Nothing counts
// from a zero whose readings disagree.

#include <functional>
#include <string>

#include "server/application/motion/sampling.h"

namespace driftwise::application {

struct ZeroVisit {
  std::string cause;      // of the moves and of what is told: "zero after line 3"
  bool is_there = false;  // the axes have arrived: the first readings need no move
  bool in_datum = true;   // the second instruments of a set-up count from it, and have to agree
  // After each approach, before it is read: the zeroing of the instruments.
  std::function<Awaitable<Result<void>>()> arrived = {};
  // Readings of each attempt, the good one included; they may be moved away.
  std::function<void(Sampling&)> took = {};
};

// Reads again, then comes again from the side that the axes came from, as decide() has it for a row
// (point_decision.h); each time is an event. Errors besides those of go_to, take_readings and
// `arrived`: failed_precondition ZERO_NOT_REACHED, the budget is used up.
Awaitable<Result<Sampling>> visit_zero(RunScope& scope, ZeroVisit visit);

}  // namespace driftwise::application
