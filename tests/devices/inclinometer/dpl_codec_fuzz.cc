// Whatever an inclinometer sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/inclinometer/dpl_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)inclinometer::parse_identity(bytes);
  if (const auto tilt = inclinometer::parse_tilt(bytes);
      tilt && !(std::isfinite(tilt->x_deg) && std::isfinite(tilt->y_deg)))
    std::abort();
  return 0;
}
