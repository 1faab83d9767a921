#pragma once

#include "server/core/description/cell_description.h"
#include "server/core/ports/device.h"

namespace driftwise::application {

// One device: its description and its state now.
struct DeviceStatus {
  DeviceDescription description;
  DeviceHealth health;
  // It measures the pose and the set-up in use does not name it: nothing waits for it.
  bool unused = false;
};

}  // namespace driftwise::application
