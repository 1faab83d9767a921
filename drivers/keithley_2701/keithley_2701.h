#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/instrument.h"

namespace driftwise::drivers {

// A Keithley 2700 / 2701 with a scanner card, over TCP (port 1394) or a serial line: pt1000 probes
// in four-wire ohms, or sensors whose output is a voltage. Options: scan_options.h. Uses
// DeviceDescription::probes (input, R0, A, B) or voltages, and timeout_s (of everything but a
// scan). Devices at one address share the connection of `shared`; nullptr: a connection of its own.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, BAD_PROBES). Connects in prepare() or the
// first call, not here.
Result<std::unique_ptr<Instrument>> make_keithley_2701(const DeviceDescription& device,
                                                       asio::any_io_executor executor, Clock& clock,
                                                       SharedByAddress* shared = nullptr);

}  // namespace driftwise::drivers
