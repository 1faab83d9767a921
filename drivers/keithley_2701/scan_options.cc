#include "drivers/keithley_2701/scan_options.h"

#include "server/core/try.h"

namespace driftwise::keithley {

Result<Options> read_options(const DeviceDescription& device, bool on_serial_line) {
  transport::OptionReader reader(device);
  Options out;
  const std::string end =
      reader.choice("terminator", on_serial_line ? "cr" : "lf", {"lf", "cr", "crlf"});
  out.send_end = end == "lf" ? "\n" : end == "cr" ? "\r" : "\r\n";
  // A level or a gauge is noisier by itself than by a short integration; ohms want a millikelvin.
  constexpr double kOhmsNplc = 5, kVoltsNplc = 1;
  const bool measures_volts = !device.voltages.sensors.empty();
  out.nplc = reader.number("nplc", measures_volts ? kVoltsNplc : kOhmsNplc, 0.01, 50);
  out.mains_hz = reader.number("mains_hz", out.mains_hz, 50, 60);
  if (measures_volts) {
    out.range_v = reader.number("range_v", out.range_v, 0.1, 1000);
  } else {
    out.range_ohm = reader.number("range_ohm", out.range_ohm, 100, 1e6);
    out.offset_compensation = reader.on_off("offset_compensation", out.offset_compensation);
  }
  out.relay_s = reader.number("relay_s", out.relay_s, 0, 10);
  out.require_card = reader.on_off("require_card", out.require_card);
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

bool is_of_connection(std::string_view option) {
  return option != "nplc" && option != "range_ohm" && option != "range_v" &&
         option != "offset_compensation";
}

}  // namespace driftwise::keithley
