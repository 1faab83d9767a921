#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/motion_controller.h"

namespace driftwise::drivers {

// A controller that speaks PI GCS 2.0 over TCP (port 50000) or a serial line.
// Options: gcs_options.h. Uses DeviceDescription::axes (device_axis, soft limits) and timeout_s.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, NO_AXES). Connects in prepare() or the first
// call, not here.
Result<std::unique_ptr<MotionController>> make_pi_gcs(const DeviceDescription& device,
                                                      asio::any_io_executor executor, Clock& clock);

}  // namespace driftwise::drivers
