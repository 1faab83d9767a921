#pragma once
// Devices and robots that a cell file may describe and this version cannot use yet.

#include "server/core/description/cell_description.h"

namespace driftwise::application {

// Errors, invalid_argument, naming the device or robot and what to do: NO_CONTROLLER,
// TWO_CONTROLLERS (without [[robot]]), TWO_LOADS, ROLE_NOT_USED; failed_precondition:
// TWO_ROBOTS.
Result<void> check_usable(const CellDescription& cell);

}  // namespace driftwise::application
