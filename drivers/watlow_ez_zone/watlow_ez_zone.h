#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/stabiliser.h"

namespace driftwise::drivers {

// A Watlow EZ-ZONE PM over Modbus TCP ("host:port") or RTU ("/dev/..."). libmodbus blocks: it lives
// on a thread of its own, which the destructor joins (at most one time-out later). Options:
// watlow_options.h. Uses DeviceDescription::id for its channels and timeout_s. Errors:
// invalid_argument (BAD_OPTION, BAD_ADDRESS). Connects in prepare() or the first call, not here.
Result<std::unique_ptr<Stabiliser>> make_watlow_ez_zone(const DeviceDescription& device,
                                                        asio::any_io_executor executor,
                                                        Clock& clock);

}  // namespace driftwise::drivers
