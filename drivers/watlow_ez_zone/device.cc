#include "drivers/watlow_ez_zone/watlow_ez_zone.h"
#include "server/core/devices/device_kind.h"
#include "server/core/devices/role_settings.h"
#include "server/core/ports/made_device.h"

namespace driftwise::device_kind {
namespace {

constexpr OutputOption kLoops[] = {{"unit_id", "1"}, {"zone", "1"}};

}  // namespace

extern const DeviceKind watlow_ez_zone;
const DeviceKind watlow_ez_zone{.id = "watlow-ez-zone",
                                .role = DeviceRole::stabiliser,
                                .read_settings = read_stabiliser_settings,
                                .channels = channels_of_settings,
                                .make = [](const DeviceDescription& device,
                                           const DeviceContext& context) -> Result<MadeDevice> {
                                  return drivers::make_watlow_ez_zone(device, context.executor,
                                                                      context.clock,
                                                                      context.shared.get());
                                },
                                .output_options = kLoops};

}  // namespace driftwise::device_kind
