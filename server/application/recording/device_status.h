#pragma once

#include "server/core/description/cell_description.h"
#include "server/core/ports/device.h"

namespace driftwise::application {

// One device: its description and its state now.
struct DeviceStatus {
  DeviceDescription description;
  DeviceHealth health;
};

}  // namespace driftwise::application
