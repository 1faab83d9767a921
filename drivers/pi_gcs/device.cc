#include "drivers/pi_gcs/pi_gcs.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {

extern const DeviceKind pi_gcs;
const DeviceKind pi_gcs{.id = "pi-gcs",
                        .role = DeviceRole::motion,
                        .read_settings = read_motion_settings,
                        .channels = channels_of_settings,
                        .make = [](const DeviceDescription& device,
                                   const DeviceContext& context) -> Result<MadeDevice> {
                          return drivers::make_pi_gcs(device, context.executor, context.clock,
                                                      context.claims);
                        }};

}  // namespace driftwise::device_kind
