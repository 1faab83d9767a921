#include "drivers/simulated/plant/make_plant.h"

#include "drivers/simulated/plant/plant_file.h"

namespace driftwise::simulated {

std::unique_ptr<LinearAxisPlant> make_plant(const std::filesystem::path& file,
                                            const PlantOptions& options) {
  return std::make_unique<LinearAxisPlant>(read_plant_file(file, options.overrides), options.seed,
                                           options.epoch_ns);
}

}  // namespace driftwise::simulated
