#pragma once
// A device's answer with what was found wrong in it. The answer itself stays as it was given.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/reading.h"

namespace driftwise {

// A value that failed a test and joins no point. docs/database.md names the tests: missing,
// not_finite, range, step, together, frozen.
struct RejectedValue {
  std::string channel;
  std::string test;
  std::string reason;  // a sentence: the value, the limit, where the limit comes from
};

struct JudgedReading : Reading {
  std::vector<RejectedValue> rejected;

  bool is_rejected(std::string_view channel_name) const {
    for (const auto& one : rejected)
      if (one.channel == channel_name) return true;
    return false;
  }
};

// The same for the record, which keeps it beside the reading.
struct RejectedAnswer {
  std::string device;
  CellTime start;  // of the reading
  std::int64_t sequence = 0;
  RejectedValue value;
};

}  // namespace driftwise
