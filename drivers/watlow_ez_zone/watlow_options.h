#pragma once

#include "drivers/transport/address.h"
#include "drivers/watlow_ez_zone/registers.h"
#include "server/core/description/cell_description.h"
#include "server/core/devices/loop_tuning.h"
#include "server/core/result.h"

namespace driftwise::watlow {

struct Options {
  int unit_id = 1;  // Modbus address
  int zone = 1;
  WordOrder word_order = WordOrder::low_first;  // word_order = low_first | high_first
  Unit unit = Unit::fahrenheit;                 // unit = F | C: of the numbers on the wire
  bool check_unit = true;                       // compare with register 2490
  LoopTuning declared{};  // what its loop should have: compared, never written by itself
  transport::SerialSettings serial{.baud = 9600};
};

// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

}  // namespace driftwise::watlow
