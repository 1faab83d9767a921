#pragma once
// From a plant file to a running plant: the one door through which emulators and tests come in.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/simulated/plant/delta_cube/delta_cube_plant.h"
#include "drivers/simulated/plant/linear_axis/linear_axis_plant.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_plant.h"
#include "drivers/simulated/plant/min_angle/min_angle_plant.h"
#include "drivers/simulated/plant/two_robots/two_robots_plant.h"

namespace driftwise::simulated {

struct PlantOptions {
  std::uint64_t seed = 1;
  std::vector<std::string> overrides;  // "room.wander_w=0", over what the file says; same checks
  TimeNs epoch_ns =
      0;  // cell UTC at which the plant's story starts (set-point step etc. count from it)
};

// "plant.toml:41: part.base_top.mass_kg: found 'heavy' (string), expected a number above 0". For a
// value that an override put in, the text says "override" instead of file and line.
class PlantFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads, checks and warms the plant up (start_hours_before, about 0.2 s of processor time per
// robot axis). Throws PlantFileError on anything wrong in the file or in an override; nothing else
// fails.
std::unique_ptr<CellPlant> make_any_plant(const std::filesystem::path& file,
                                          const PlantOptions& options);
// The same for a file that must be of this kind.
std::unique_ptr<LinearAxisPlant> make_plant(const std::filesystem::path& file,
                                            const PlantOptions& options);
std::unique_ptr<MicroNanoPlant> make_micro_nano_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options);
std::unique_ptr<MinAnglePlant> make_min_angle_plant(const std::filesystem::path& file,
                                                    const PlantOptions& options);
std::unique_ptr<TwoRobotsPlant> make_two_robots_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options);
std::unique_ptr<DeltaCubePlant> make_delta_cube_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options);

}  // namespace driftwise::simulated
