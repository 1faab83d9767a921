#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/stabiliser.h"

namespace driftwise::drivers {

// A Watlow EZ-ZONE PM over Modbus TCP ("host:port") or RTU ("/dev/..."). libmodbus blocks: it lives
// on a thread of its own, for which the destructor waits (at most one time-out for each unit of the
// line). Devices on one serial line of `shared` are units of one bus and take turns. Options:
// watlow_options.h. Uses DeviceDescription::id for its channels and timeout_s. Errors:
// invalid_argument (BAD_OPTION, BAD_ADDRESS). Connects in prepare() or the first call, not here.
Result<std::unique_ptr<Stabiliser>> make_watlow_ez_zone(const DeviceDescription& device,
                                                        asio::any_io_executor executor,
                                                        Clock& clock,
                                                        SharedByAddress* shared = nullptr);

}  // namespace driftwise::drivers
