#include "drivers/load_actuator/load_actuator.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {

extern const DeviceKind load_actuator;
const DeviceKind load_actuator{.id = "load-actuator",
                               .role = DeviceRole::load,
                               .read_settings = read_load_settings,
                               .channels = channels_of_settings,
                               .make = [](const DeviceDescription& device,
                                          const DeviceContext& context) -> Result<MadeDevice> {
                                 return drivers::make_load_actuator(
                                     device, context.executor, context.clock, context.shared.get());
                               }};

}  // namespace driftwise::device_kind
