#include "drivers/keithley_2701/keithley_2701.h"
#include "drivers/keithley_2701/voltage_settings.h"
#include "server/core/devices/device_kind.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {

extern const DeviceKind keithley_2701;
const DeviceKind keithley_2701{.id = "keithley-2701",
                               .role = DeviceRole::temperature,
                               .read_settings = keithley::read_settings,
                               .channels = keithley::channels_of,
                               .make = [](const DeviceDescription& device,
                                          const DeviceContext& context) -> Result<MadeDevice> {
                                 return drivers::make_keithley_2701(
                                     device, context.executor, context.clock, context.shared.get());
                               }};

}  // namespace driftwise::device_kind
