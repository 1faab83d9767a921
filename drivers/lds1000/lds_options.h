#pragma once

#include <optional>
#include <string>

#include "drivers/lds1000/lds_codec.h"
#include "drivers/transport/address.h"
#include "server/core/description/cell_description.h"

namespace driftwise::lds1000 {

struct Options {
  std::optional<Unit> unit;           // "sec" | "urad": the set-up must be in it; none: either
  std::optional<double> increment;    // likewise; 0.2 is 0.02 arcsec over +-400 arcsec
  int integration_ms = 100;           // sent as KI at every connection
  std::string end_of_command = "\r";  // terminator: cr | lf | crlf (not openly documented)
  transport::SerialSettings serial;   // 9600 8N1
};

// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

}  // namespace driftwise::lds1000
