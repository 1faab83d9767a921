#include "drivers/touch_probe/nd28x_probe.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {
namespace {

std::vector<Channel> channels_of_probe(const DeviceDescription& device) {
  auto out = channels_of_settings(device);
  const auto options = driftwise::touch_probe::read_options(device);
  if (const auto* length = device.length(); length && options && options->readings > 1)
    out.push_back({length->channel.symbol + "_std", "nm"});
  return out;
}

}  // namespace

extern const DeviceKind touch_probe;
const DeviceKind touch_probe{
    .id = "heidenhain-nd28x",
    .role = DeviceRole::length,
    .read_settings = read_length_settings,
    .channels = channels_of_probe,
    .make = [](const DeviceDescription& device,
               const DeviceContext& context) -> Result<MadeDevice> {
      DRIFTWISE_TRY(const auto options, driftwise::touch_probe::read_options(device));
      DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
      return std::make_unique<driftwise::touch_probe::Nd28xProbe>(
          device, options, address, context.executor, context.clock, context.shared.get());
    },
    .shares_line = true};

}  // namespace driftwise::device_kind
