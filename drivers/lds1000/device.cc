#include "drivers/lds1000/newport_lds1000.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {

extern const DeviceKind lds1000;
const DeviceKind lds1000{.id = "newport-lds1000",
                         .role = DeviceRole::angle,
                         .read_settings = read_angle_settings,
                         .channels = channels_of_settings,
                         .make = [](const DeviceDescription& device,
                                    const DeviceContext& context) -> Result<MadeDevice> {
                           return drivers::make_newport_lds1000(
                               device, context.executor, context.clock, context.shared.get());
                         }};

}  // namespace driftwise::device_kind
