#pragma once
// [[robot]] of cell.toml: the cell's kinematic structures, each with its controller.

#include "server/core/description/cell_description.h"
#include "server/formats/cell_file/cell_file_devices.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// Call it before the devices: fills out.robots with what the file says and, where there are
// several, taken.robots. Refused: DUPLICATE_ID, BAD_ID.
void read_robots(TomlReader& top, CellDescription& out, TakenNames& taken, TomlProblem& problem);

// Call it when the devices are known: each robot has a controller and axes of it, each axis one
// robot. A file without [[robot]] gets one robot without id, where it has a controller.
// Refused: BAD_CONTROLLER, BAD_CHANNEL, DUPLICATE_CHANNEL, MISSING_KEY, TWO_KINEMATICS,
// AXIS_OF_NO_ROBOT.
void complete_robots(TomlReader& top, CellDescription& out);

}  // namespace driftwise::formats
