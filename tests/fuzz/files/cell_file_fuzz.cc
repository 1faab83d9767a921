// Any bytes: an error with file and line, or a description that holds what the daemon relies on.

#include <cstdint>
#include <cstdlib>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto cell = formats::parse_cell_file(text, "cell.toml", drivers::all_devices());
  if (!cell) {
    if (!cell.error().message.starts_with("cell.toml:")) std::abort();
    return 0;
  }
  if (cell->devices.empty() || cell->name.empty()) std::abort();
  for (const auto& device : cell->devices) {
    if (cell->clock.speed != 1.0 && !device.on_loopback()) std::abort();
    for (const auto& axis : device.axes())
      if (!(axis.min_mm < axis.max_mm)) std::abort();
  }
  return 0;
}
