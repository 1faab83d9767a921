#include "drivers/nut_ups/nut_ups.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {
namespace {

std::vector<Channel> channels_of_ups(const DeviceDescription& device) {
  const std::string stem = symbol_from_id(device.id);
  return {{stem + "_on_battery", "1"},
          {stem + "_low_battery", "1"},
          {stem + "_forced", "1"},
          {stem + "_charge", "pct"},
          {stem + "_runtime", "s"}};
}

constexpr OutputOption kSupplies[] = {{"ups", "ups"}};

}  // namespace

extern const DeviceKind nut_ups;
const DeviceKind nut_ups{
    .id = "nut-ups",
    .role = DeviceRole::supply,
    .read_settings = read_supply_settings,
    .channels = channels_of_ups,
    .make = [](const DeviceDescription& device,
               const DeviceContext& context) -> Result<MadeDevice> {
      DRIFTWISE_TRY(const auto options, driftwise::nut_ups::read_options(device));
      DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
      return std::make_unique<driftwise::nut_ups::NutUps>(device, options, address,
                                                          context.executor, context.clock);
    },
    .output_options = kSupplies};

}  // namespace driftwise::device_kind
