#include "drivers/pi_gcs/pi_gcs.h"

#include "drivers/pi_gcs/gcs_controller.h"
#include "drivers/transport/address_key.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<MotionController>> make_pi_gcs(const DeviceDescription& device,
                                                      asio::any_io_executor executor, Clock& clock,
                                                      std::shared_ptr<locks::Claims> claims) {
  DRIFTWISE_TRY(auto options, gcs::read_options(device));
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  if (device.axes().empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoAxes,
                "device '" + device.id + "' (pi-gcs) has no [[axes]]");
  if (claims)
    for (const auto& key : transport::keys_of(address))
      DRIFTWISE_RETURN_IF_ERROR(claims->take(device.id, key));
  return std::make_unique<gcs::GcsController>(device, std::move(options), address,
                                              std::move(executor), clock, std::move(claims));
}

}  // namespace driftwise::drivers
