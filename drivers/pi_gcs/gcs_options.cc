#include "drivers/pi_gcs/gcs_options.h"

#include "server/core/try.h"

namespace driftwise::gcs {

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.reference = reader.choice("reference", out.reference, {"FRF", "INI"});
  out.referenced_by =
      reader.choice("referenced_by", out.referenced_by, {"FRF?", "status", "memory"});
  out.travel_query = reader.on_off("travel_query", out.travel_query);
  out.pipelining = reader.on_off("pipelining", out.pipelining);
  out.start_delay_s = reader.number("start_delay_s", out.start_delay_s, 0, 10);
  out.velocity_mm_s = reader.number("velocity_mm_s", out.velocity_mm_s, 0, 1000);
  out.velocity_command = reader.choice("velocity_command", out.velocity_command, {"VLS", "VEL"});
  out.home_poll_s = reader.number("home_poll_s", out.home_poll_s, 0.001, 10);
  out.home_stall_s = reader.number("home_stall_s", out.home_stall_s, 0.1, 600);
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

}  // namespace driftwise::gcs
