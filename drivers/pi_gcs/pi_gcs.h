#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "server/core/ports/clock.h"
#include "server/core/ports/motion_controller.h"
#include "server/locks/claims.h"

namespace driftwise::drivers {

// A controller that speaks PI GCS 2.0 over TCP (port 50000) or a serial line.
// Options: gcs_options.h. Uses DeviceDescription::axes (device_axis, soft limits) and timeout_s.
// Errors: invalid_argument (BAD_OPTION, BAD_ADDRESS, NO_AXES). Connects in prepare() or the first
// call, not here.
//
// claims: the machines that this process drives; none: nobody else can drive this one. The
// controller is claimed by what its address resolves to (here, as far as it resolves), and after
// each connection by the other end's address and by the serial number in its identity; nothing but
// *IDN? and a stop is sent to one that another process drives. Errors of that: failed_precondition
// CONTROLLER_IN_USE. GCS 2.0 has no lock of its own that keeps another computer away.
Result<std::unique_ptr<MotionController>> make_pi_gcs(
    const DeviceDescription& device, asio::any_io_executor executor, Clock& clock,
    std::shared_ptr<locks::Claims> claims = nullptr);

}  // namespace driftwise::drivers
