#include "drivers/watlow_ez_zone/watlow_ez_zone.h"

#include "drivers/watlow_ez_zone/peltier_stabiliser.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Stabiliser>> make_watlow_ez_zone(const DeviceDescription& device,
                                                        asio::any_io_executor executor,
                                                        Clock& clock) {
  DRIFTWISE_TRY(const auto options, watlow::read_options(device));
  DRIFTWISE_TRY(auto address, transport::parse_address(device.address));
  return std::make_unique<watlow::PeltierStabiliser>(device, options, std::move(address),
                                                     std::move(executor), clock);
}

}  // namespace driftwise::drivers
