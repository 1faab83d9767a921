#pragma once
// plant.toml with overrides -> the parameters of its robot.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "drivers/simulated/plant/delta_cube/delta_cube_parameters.h"
#include "drivers/simulated/plant/linear_axis/linear_axis_parameters.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"
#include "drivers/simulated/plant/min_angle/min_angle_parameters.h"

namespace driftwise::simulated {

using PlantParameters = std::variant<LinearAxisParameters, MicroNanoParameters, MinAngleParameters,
                                     DeltaCubeParameters>;

// Throws PlantFileError (make_plant.h).
PlantParameters read_plant_file(const std::filesystem::path& file,
                                std::span<const std::string> overrides);
// The same from text; name stands in the errors for the file.
PlantParameters parse_plant_file(std::string_view text, const std::string& name,
                                 std::span<const std::string> overrides);

}  // namespace driftwise::simulated
