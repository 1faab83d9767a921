// Whatever an autocollimator's controller sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/lds1000/lds_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)lds1000::parse_version(bytes);
  (void)lds1000::parse_status(bytes);
  (void)lds1000::parse_error(bytes);
  (void)lds1000::parse_integration_ms(bytes);
  for (const int axis : {1, 2}) {
    if (const auto value = lds1000::parse_value(bytes, axis); value && !std::isfinite(*value))
      std::abort();
    if (const auto set_up = lds1000::parse_set_up(bytes, axis); set_up && !(set_up->increment > 0))
      std::abort();
  }
  return 0;
}
