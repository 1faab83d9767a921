#pragma once
// Whether a daemon may start with a cell file: what the devices of the file are together. Texts of
// cells that are on record are read without it, so that a new rule hides no run.

#include <string>

#include "server/core/description/cell_description.h"

namespace driftwise::formats {

// cell: as read_cell_file() gave it; path: of the file, for messages. The first problem, with
// file, line and key. Errors, invalid_argument:
//   NO_CONTROLLER, TWO_CONTROLLERS (one that no [[robot]] names), TWO_LOADS, ROLE_NOT_USED
//   NO_INSTRUMENT     no device measures a length or rotation of the pose
//   DUPLICATE_OUTPUT  one output of a device is two channels: two devices at one place of one
//                     address, two motor coordinates on one axis of a controller, one input of a
//                     scanner. Instruments of a pose may share it where no [[setup]] names both.
//   NOT_MEASURED      a pose coordinate of a linear axis in [kinematics] that nothing measures
Result<void> check_startable(const CellDescription& cell, const std::string& path);

}  // namespace driftwise::formats
