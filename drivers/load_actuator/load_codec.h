#pragma once
// The text lines of the load actuator (our own definition, docs/emulators.md), bytes <-> values.
// Pure.
//
//   IDN?         OK <maker> <model> <serial>
//   LOAD?        OK <newton> <1 resting | 0 moving weights>
//   LOAD 2.305   OK                      then the weights move for a while
//   anything     ERR <code> <text>       1 syntax, 2 no such load, 3 busy, 4 jammed

#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::load_actuator {

struct Load {
  double force_n = 0;
  bool resting = true;
};

// One reply line with or without its end. Errors: data_loss BAD_REPLY; for "ERR <code> <text>":
// internal SYNTAX (1), out_of_range NO_SUCH_LOAD (2), failed_precondition LOAD_BUSY (3),
// LOAD_JAMMED (4), REFUSED (any other), each with the device's own text.
Result<std::string> parse_identity(std::string_view reply);  // "Driftwise weights 0001"
Result<Load> parse_load(std::string_view reply);
Result<void> parse_ok(std::string_view reply);

std::string load_command(double force_n);  // "LOAD 2.305", shortest digits that read back

}  // namespace driftwise::load_actuator
