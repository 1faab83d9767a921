// Whatever a Keithley scanner sends.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/keithley_2701/platinum_resistance.h"
#include "drivers/keithley_2701/scan_codec.h"
#include "server/core/data/reading.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const auto list = keithley::parse_channel_list(bytes); list && !list->empty()) {
    const auto again = keithley::parse_channel_list(keithley::encode_channel_list(*list));
    if (!again || *again != *list) std::abort();
  }
  (void)keithley::parse_device_error(bytes);
  static const std::vector<int> kScanned{101, 102};
  if (const auto fields = keithley::parse_fields(bytes, 6)) {
    if (fields->size() != 6) std::abort();
    if (const auto layout = keithley::learn_layout(*fields, kScanned)) {
      const auto scan = keithley::read_scan(*fields, *layout, kScanned);
      if (!scan || scan->size() != 2) std::abort();
      for (const auto& one : *scan) {
        const double degc = platinum::degc_from_ohm(one.value, {});
        if (!std::isnan(degc) && (degc < -200.001 || degc > 850.001)) std::abort();
      }
    }
  }
  return 0;
}
