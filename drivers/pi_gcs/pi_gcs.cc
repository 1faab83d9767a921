#include "drivers/pi_gcs/pi_gcs.h"

#include "drivers/pi_gcs/gcs_controller.h"
#include "drivers/transport/address_key.h"

namespace driftwise::drivers {

Result<std::unique_ptr<MotionController>> make_pi_gcs(const DeviceDescription& device,
                                                      asio::any_io_executor executor, Clock& clock,
                                                      std::shared_ptr<locks::Claims> claims) {
  auto options = gcs::read_options(device);
  if (!options) return tl::unexpected(options.error());
  const auto address = transport::parse_address(device.address);
  if (!address) return tl::unexpected(address.error());
  if (device.axes.empty())
    return fail(ErrorCode::invalid_argument, "NO_AXES",
                "device '" + device.id + "' (pi-gcs) has no [[axes]]");
  if (claims)
    for (const auto& key : transport::keys_of(*address))
      if (auto ours = claims->take(device.id, key); !ours) return tl::unexpected(ours.error());
  return std::make_unique<gcs::GcsController>(device, std::move(*options), *address,
                                              std::move(executor), clock, std::move(claims));
}

}  // namespace driftwise::drivers
