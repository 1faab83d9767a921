#pragma once
// Commands of the motors, under the names of their channels.

#include "server/core/description/cell_description.h"
#include "server/core/records/records.h"

namespace driftwise::application {

// Sets commanded_mm, in order of the axes. Where the motors are not q1, q2, ... in this order
// (several robots), values get each command under its motor's name as well: ma.q1_cmd_mm.
void set_commands(const CellDescription& description, std::vector<double> commanded_mm,
                  PointRecord& point);

}  // namespace driftwise::application
