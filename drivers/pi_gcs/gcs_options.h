#pragma once

#include <string>

#include "drivers/transport/address.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::gcs {

// What GCS leaves open or what is not confirmed for every controller (U in PROTOCOLS.md section 8):
// option by option, with the default. Any of them may be set in the cell file.
struct Options {
  std::string reference = "FRF";  // FRF | INI (older controllers)
  std::string referenced_by =
      "FRF?";  // FRF? | status (byte 0x04) | memory: known only once this driver has homed
  bool travel_query = true;  // TMN?, TMX? exist: the soft limits are checked against them
  bool pipelining = false;   // several queries in one message: one round trip per state()
  double start_delay_s =
      0.2;  // after MOV "not moving" counts only from here on, or once motion was seen
  double velocity_mm_s = 0;              // 0: as the controller has it
  std::string velocity_command = "VLS";  // VLS (all axes together) | VEL (each)
  double home_poll_s = 0.1;              // cell time between two looks while referencing
  double home_stall_s = 20.0;  // referencing has failed when no axis moved by 1 um for so long
  transport::SerialSettings serial{.baud = 115200};
};

// Errors: invalid_argument, reason BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

}  // namespace driftwise::gcs
