#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/instrument.h"

namespace driftwise::drivers {

// One channel of a laser interferometer behind its adapter process (text lines over TCP).
// Options: adapter_options.h. Uses DeviceDescription::length and timeout_s.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, NO_LENGTH). Connects in prepare() or the first
// call, not here. Devices on one serial line of `shared` take turns.
Result<std::unique_ptr<Instrument>> make_interferometer_adapter(const DeviceDescription& device,
                                                                asio::any_io_executor executor,
                                                                Clock& clock,
                                                                SharedByAddress* shared = nullptr);

}  // namespace driftwise::drivers
