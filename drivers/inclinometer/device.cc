#include "drivers/inclinometer/dpl_inclinometer.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {

extern const DeviceKind inclinometer;
const DeviceKind inclinometer{
    .id = "meas-dpl",
    .role = DeviceRole::angle,
    .read_settings = driftwise::inclinometer::read_settings,
    .channels = channels_of_settings,
    .make = [](const DeviceDescription& device,
               const DeviceContext& context) -> Result<MadeDevice> {
      DRIFTWISE_TRY(const auto options, driftwise::inclinometer::read_options(device));
      DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
      return std::make_unique<driftwise::inclinometer::DplInclinometer>(
          device, options, address, context.executor, context.clock, context.shared.get());
    },
    .shares_line = true};

}  // namespace driftwise::device_kind
