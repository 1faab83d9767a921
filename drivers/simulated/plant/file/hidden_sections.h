#pragma once
// [hidden.<name>] of a plant file. Read last: the tables name parts, materials, axes and beams of
// the cell.

#include "drivers/simulated/plant/file/plant_fields.h"
#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

// Nothing where the file has no [hidden]. Refuses more than kMaxHidden, and what the robot lacks.
void hidden_sections(Fields& root, const Materials& materials, CellParameters& cell);

}  // namespace driftwise::simulated
