#pragma once
// The plant files of the robots: what [plant] kind says decides which reader is asked.

#include "drivers/simulated/plant/delta_cube/delta_cube_parameters.h"
#include "drivers/simulated/plant/file/plant_fields.h"
#include "drivers/simulated/plant/linear_axis/linear_axis_parameters.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"
#include "drivers/simulated/plant/min_angle/min_angle_parameters.h"
#include "drivers/simulated/plant/two_robots/contact_parameters.h"

namespace driftwise::simulated {

LinearAxisParameters linear_axis_sections(Fields root);
MicroNanoParameters micro_nano_sections(Fields root);
MinAngleParameters min_angle_sections(Fields root);
// All but the two robots themselves.
TwoRobotsParameters two_robots_sections(Fields root);
DeltaCubeParameters delta_cube_sections(Fields root);

}  // namespace driftwise::simulated
