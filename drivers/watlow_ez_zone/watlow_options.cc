#include "drivers/watlow_ez_zone/watlow_options.h"

#include "server/core/try.h"

namespace driftwise::watlow {

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.unit_id = reader.integer("unit_id", out.unit_id, 1, 247);
  out.zone = reader.integer("zone", out.zone, 1, 12);
  if (reader.choice("word_order", "low_first", {"low_first", "high_first"}) == "high_first")
    out.word_order = WordOrder::high_first;
  if (reader.choice("unit", "F", {"F", "C"}) == "C") out.unit = Unit::celsius;
  out.check_unit = reader.on_off("check_unit", out.check_unit);
  const auto declared = [&reader](const char* name, std::optional<double>& value) {
    constexpr double kNone = -1;
    const double number = reader.number(name, kNone, 0, 9999);
    if (number != kNone) value = number;
  };
  declared("heat_band_k", out.declared.heat_band_k);
  declared("cool_band_k", out.declared.cool_band_k);
  declared("integral_s", out.declared.integral_s);
  declared("derivative_s", out.declared.derivative_s);
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

}  // namespace driftwise::watlow
