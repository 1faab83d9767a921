#pragma once

#include <vector>

#include "server/core/ports/made_device.h"

namespace driftwise::application {

// The cell's devices, each behind the port of its role; made by main.
using Devices = std::vector<MadeDevice>;

}  // namespace driftwise::application
