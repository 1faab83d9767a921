#include "drivers/watlow_ez_zone/watlow_ez_zone.h"

#include "drivers/watlow_ez_zone/peltier_stabiliser.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Stabiliser>> make_watlow_ez_zone(const DeviceDescription& device,
                                                        asio::any_io_executor executor,
                                                        Clock& clock) {
  const auto options = watlow::read_options(device);
  if (!options) return tl::unexpected(options.error());
  auto address = transport::parse_address(device.address);
  if (!address) return tl::unexpected(address.error());
  return std::make_unique<watlow::PeltierStabiliser>(device, *options, std::move(*address),
                                                     std::move(executor), clock);
}

}  // namespace driftwise::drivers
