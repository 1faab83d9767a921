// plant.toml: whatever the bytes, either parameters or PlantFileError.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/simulated/plant/file/make_plant.h"
#include "drivers/simulated/plant/file/plant_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    parse_plant_file(text, "fuzz", {});
  } catch (const PlantFileError&) {
  }
  try {
    parse_plant_file("[room]\nx = 1\n", "fuzz", std::vector<std::string>{std::string(text)});
  } catch (const PlantFileError&) {
  }
  return 0;
}
