// Whatever an upsd sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/nut_ups/nut_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)nut_ups::is_version(bytes);
  if (const auto value = nut_ups::parse_value(bytes, "rack", "ups.status"); value && *value)
    (void)nut_ups::parse_status(**value);
  (void)nut_ups::parse_status(bytes);
  if (const auto value = nut_ups::parse_quantity(bytes, "battery.charge");
      value && !(std::isfinite(*value) && *value >= 0))
    std::abort();
  return 0;
}
