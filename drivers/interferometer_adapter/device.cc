#include "drivers/interferometer_adapter/adapter_options.h"
#include "drivers/interferometer_adapter/interferometer_adapter.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {
namespace {

constexpr OutputOption kAdapterOutputs[] = {{"channel", "1"}};

// Options that are wrong give none of theirs: make() refuses them with their reason.
std::vector<Channel> channels_of_adapter(const DeviceDescription& device) {
  auto out = channels_of_settings(device);
  if (const auto* length = device.length()) out.push_back({length->channel.symbol + "_std", "nm"});
  const auto options = driftwise::adapter::read_options(device);
  if (!options) return out;
  for (const auto& name : {options->air_channel, options->level_channel})
    if (auto channel = parse_channel(name)) out.push_back(std::move(*channel));
  return out;
}

}  // namespace

extern const DeviceKind interferometer_adapter;
const DeviceKind interferometer_adapter{
    .id = "interferometer-adapter",
    .role = DeviceRole::length,
    .read_settings = read_length_settings,
    .channels = channels_of_adapter,
    .make = [](const DeviceDescription& device,
               const DeviceContext& context) -> Result<MadeDevice> {
      return drivers::make_interferometer_adapter(device, context.executor, context.clock,
                                                  context.shared.get());
    },
    .output_options = kAdapterOutputs};

}  // namespace driftwise::device_kind
