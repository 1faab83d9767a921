#pragma once

#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::adapter {

struct Options {
  int channel = 1;                          // the adapter's number, from 1
  int samples = 4096;                       // 2048 | 4096 | 8192 | 16384 averaged per reading
  double sample_rate_hz = 5000;             // lower bound, for the time-out only
  double dead_path_mm = 0;                  // sent before every zero
  double max_air_age_s = 10;                // an older air temperature is missing
  double max_clock_offset_s = 60;           // of the adapter's clock to UTC: beyond it an alarm
  std::string air_channel = "air_degC";     // "": none
  std::string level_channel = "level_pct";  // "": none
};

// Errors: invalid_argument, BAD_OPTION or BAD_CHANNEL.
Result<Options> read_options(const DeviceDescription& device);

}  // namespace driftwise::adapter
