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
#include "drivers/simulated/plant/two_robots/contact_parameters.h"

namespace driftwise::simulated {

using PlantParameters = std::variant<LinearAxisParameters, MicroNanoParameters, MinAngleParameters,
                                     TwoRobotsParameters, DeltaCubeParameters>;

// Throws PlantFileError (make_plant.h).
PlantParameters read_plant_file(const std::filesystem::path& file,
                                std::span<const std::string> overrides);
// The same from text; name stands in the errors for the file. Two robots: the file names one file
// for each, from its own folder. An override "upper.axis.hold_max_nm=30" or "lower..." is for that
// robot's file, one of a table of this file for this file, any other for both robots.
PlantParameters parse_plant_file(std::string_view text, const std::string& name,
                                 std::span<const std::string> overrides);

}  // namespace driftwise::simulated
