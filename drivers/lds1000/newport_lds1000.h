#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/instrument.h"

namespace driftwise::drivers {

// A Newport LDS-Vector autocollimator behind its LDS1000 controller, on a serial line or a serial
// server. Options: lds_options.h. Uses DeviceDescription::angles and timeout_s.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, NO_ANGLE). Connects in prepare() or the first
// call, not here. Devices on one serial line of `shared` take turns.
Result<std::unique_ptr<Instrument>> make_newport_lds1000(const DeviceDescription& device,
                                                         asio::any_io_executor executor,
                                                         Clock& clock,
                                                         SharedByAddress* shared = nullptr);

}  // namespace driftwise::drivers
