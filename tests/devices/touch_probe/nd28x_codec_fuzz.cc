// Bytes from a read-out, of any kind.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/touch_probe/nd28x_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)touch_probe::parse_identity(bytes);
  if (const auto value_mm = touch_probe::parse_value(bytes); value_mm && !std::isfinite(*value_mm))
    std::abort();
  return 0;
}
