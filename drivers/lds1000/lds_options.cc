#include "drivers/lds1000/lds_options.h"

#include "server/core/try.h"

namespace driftwise::lds1000 {

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  const auto unit = reader.choice("unit", "any", {"any", "sec", "urad"});
  if (unit != "any") out.unit = unit == "sec" ? Unit::arcsec : Unit::microradian;
  const double increment = reader.number("increment", 0, 0, 1e4);
  if (increment > 0) out.increment = increment;
  out.integration_ms = reader.integer("integration_ms", out.integration_ms, 1, 60'000);
  const auto end = reader.choice("terminator", "cr", {"cr", "lf", "crlf"});
  out.end_of_command = end == "cr" ? "\r" : end == "lf" ? "\n" : "\r\n";
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

}  // namespace driftwise::lds1000
