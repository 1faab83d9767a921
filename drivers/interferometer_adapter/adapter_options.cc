#include "drivers/interferometer_adapter/adapter_options.h"

#include "drivers/transport/options.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::adapter {
namespace {

tl::unexpected<Error> wrong_channel(const DeviceDescription& device, const char* option,
                                    const std::string& found, const char* example) {
  return tl::unexpected(Error{ErrorCode::invalid_argument, reasons::kBadChannel,
                              "device '" + device.id + "': option " + option + ": found '" + found +
                                  "', expected a name such as " + example + ", or \"\" for none"});
}

}  // namespace

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.channel = reader.integer("channel", out.channel, 1, 16);
  out.samples = std::stoi(
      reader.choice("samples", std::to_string(out.samples), {"2048", "4096", "8192", "16384"}));
  out.sample_rate_hz = reader.number("sample_rate_hz", out.sample_rate_hz, 1, 1e9);
  out.dead_path_mm = reader.number("dead_path_mm", out.dead_path_mm, 0, 1e5);
  out.max_air_age_s = reader.number("max_air_age_s", out.max_air_age_s, 0, 1e6);
  out.max_clock_offset_s = reader.number("max_clock_offset_s", out.max_clock_offset_s, 0.001, 1e9);
  out.air_channel = reader.text("air_channel", out.air_channel);
  out.level_channel = reader.text("level_channel", out.level_channel);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  if (!out.air_channel.empty()) {
    DRIFTWISE_TRY(const auto air, parse_channel(out.air_channel));
    if (air.unit != "degC")
      return wrong_channel(device, "air_channel", out.air_channel, "air_x_degC");
  }
  if (!out.level_channel.empty()) {
    DRIFTWISE_TRY(const auto level, parse_channel(out.level_channel));
    if (!is_light_level(level.name()))
      return wrong_channel(device, "level_channel", out.level_channel, "level_x_pct");
  }
  return out;
}

}  // namespace driftwise::adapter
