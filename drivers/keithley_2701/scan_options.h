#pragma once

#include <string>
#include <string_view>

#include "drivers/transport/address.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::keithley {

struct Options {
  std::string send_end;  // terminator = lf | cr | crlf; default lf on TCP, cr on a serial line
  double nplc = 5;       // integration time in periods of the mains; of voltages 1
  double mains_hz = 50;
  double range_ohm = 1000;  // the 1 kohm range reads to 1200 ohm = 51.5 degC of a pt1000
  bool offset_compensation = true;
  double range_v = 10;       // of voltages
  double relay_s = 0.02;     // per channel, for the time-out only
  bool require_card = true;  // *OPT? must name a card: without one four-wire scanning is impossible
  transport::SerialSettings serial{.baud = 4800, .xon_xoff = true};  // the factory's
};

// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device, bool on_serial_line);
// True for an option of the connection, which every device behind it has; false for one of what the
// device measures: nplc, range_ohm, range_v, offset_compensation.
bool is_of_connection(std::string_view option);

}  // namespace driftwise::keithley
