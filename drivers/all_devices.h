#pragma once
// The kinds of devices that the daemon knows.

#include "server/core/devices/device_kind.h"

namespace driftwise::drivers {

DeviceKinds all_devices();

}  // namespace driftwise::drivers
