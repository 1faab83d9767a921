// Whatever a load actuator sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/load_actuator/load_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)load_actuator::parse_ok(bytes);
  (void)load_actuator::parse_identity(bytes);
  if (const auto load = load_actuator::parse_load(bytes); load && !std::isfinite(load->force_n))
    std::abort();
  return 0;
}
