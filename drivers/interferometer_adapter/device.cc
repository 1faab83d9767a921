#include "drivers/interferometer_adapter/interferometer_adapter.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {
namespace {

constexpr OutputOption kAdapterOutputs[] = {{"channel", "1"}};

}  // namespace

extern const DeviceKind interferometer_adapter;
const DeviceKind interferometer_adapter{
    .id = "interferometer-adapter",
    .role = DeviceRole::length,
    .read_settings = read_length_settings,
    .channels = channels_of_settings,
    .make = [](const DeviceDescription& device,
               const DeviceContext& context) -> Result<MadeDevice> {
      return drivers::make_interferometer_adapter(device, context.executor, context.clock,
                                                  context.shared.get());
    },
    .output_options = kAdapterOutputs};

}  // namespace driftwise::device_kind
