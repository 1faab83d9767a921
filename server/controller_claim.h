#pragma once
// One robot, one daemon: the lock of a motion controller's address, whichever driver speaks to it.

#include "server/core/devices/device_description.h"
#include "server/locks/claims.h"

namespace driftwise {

// Takes the lock of everything that the address of a device of role motion resolves to; does
// nothing for another role, without claims (a check drives nothing), or for an address that is none
// of the transport's: that is its driver's matter. May block for a resolver. Errors: those of
// Claims::take.
Result<void> claim_controller(const DeviceDescription& device, locks::Claims* claims);

}  // namespace driftwise
