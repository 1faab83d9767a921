// Addresses and options of a cell file as the drivers read them; registers of a Watlow.

#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "drivers/transport/address.h"
#include "drivers/watlow_ez_zone/registers.h"
#include "drivers/watlow_ez_zone/watlow_options.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)transport::parse_address(text);
  DeviceDescription device;
  const std::size_t equals = std::min(text.find('='), text.size());
  device.options[text.substr(0, equals)] = equals < text.size() ? text.substr(equals + 1) : "";
  (void)watlow::read_options(device);
  if (size >= 4) {
    float value = 0;
    std::memcpy(&value, data, 4);
    for (const auto order : {watlow::WordOrder::low_first, watlow::WordOrder::high_first}) {
      const float again = watlow::unpack_float(watlow::pack_float(value, order), order);
      if (std::memcmp(&again, &value, 4) != 0) std::abort();
    }
    (void)watlow::is_plausible(watlow::degc_from_wire(value, watlow::Unit::fahrenheit));
  }
  return 0;
}
