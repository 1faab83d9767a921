#pragma once
// plant.toml with overrides -> PlantParameters.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

// Throws PlantFileError (make_plant.h).
PlantParameters read_plant_file(const std::filesystem::path& file,
                                std::span<const std::string> overrides);
// The same from text; name stands in the errors for the file.
PlantParameters parse_plant_file(std::string_view text, const std::string& name,
                                 std::span<const std::string> overrides);

}  // namespace driftwise::simulated
