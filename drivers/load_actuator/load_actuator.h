#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/load_actuator.h"

namespace driftwise::drivers {

// An actuator that lays known weights on the end-effector (text lines over TCP, docs/emulators.md).
// It has no options. Uses DeviceDescription::force and timeout_s.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, NO_FORCE). Connects in prepare() or the first
// call, not here. Devices on one serial line of `shared` take turns.
Result<std::unique_ptr<LoadActuator>> make_load_actuator(const DeviceDescription& device,
                                                         asio::any_io_executor executor,
                                                         Clock& clock,
                                                         SharedByAddress* shared = nullptr);

}  // namespace driftwise::drivers
