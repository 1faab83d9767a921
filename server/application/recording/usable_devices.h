#pragma once
// Devices that a cell file may describe and this version cannot use yet.

#include "server/core/description/cell_description.h"

namespace driftwise::application {

// Errors, invalid_argument, naming the device or robot and what to do: NO_CONTROLLER,
// TWO_CONTROLLERS (one that no [[robot]] names), TWO_LOADS, ROLE_NOT_USED.
Result<void> check_usable(const CellDescription& cell);

}  // namespace driftwise::application
