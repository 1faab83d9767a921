// Whatever an interferometer adapter sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/interferometer_adapter/adapter_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)adapter::parse_ok(bytes);
  (void)adapter::parse_identity(bytes);
  (void)adapter::parse_unix_time(bytes);
  if (const auto measurement = adapter::parse_measurement(bytes)) {
    if (!std::isfinite(measurement->mean_nm) || measurement->end < measurement->start) std::abort();
    (void)adapter::check_status(*measurement);
  }
  return 0;
}
