#pragma once
// One device's answer: its own time stamps, its own channels. Never altered, never deleted.

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "server/core/cell_time.h"

namespace driftwise {

constexpr double kMissing =
    std::numeric_limits<double>::quiet_NaN();  // a channel that gave no value
inline bool is_missing(double value) { return std::isnan(value); }

struct ChannelValue {
  std::string channel;  // full name, "t07_degC"
  double value = kMissing;
};

struct Reading {
  std::string device;  // id in the cell file
  CellTime start;      // by the device's own clock where it has one, else when we asked
  CellTime end;        // ... and when it answered. A joined value belongs to the middle of the two
  std::int64_t sequence = 0;  // counts this device's readings since the driver started
  std::vector<ChannelValue> values;

  CellTime middle() const { return {start.utc_ns + (end.utc_ns - start.utc_ns) / 2}; }
  const double* find(std::string_view channel) const {
    for (const auto& v : values)
      if (v.channel == channel) return &v.value;
    return nullptr;
  }
};

}  // namespace driftwise
