#include "server/controller_claim.h"

#include "drivers/transport/address.h"
#include "drivers/transport/address_key.h"
#include "server/core/try.h"

namespace driftwise {

Result<void> claim_controller(const DeviceDescription& device, locks::Claims* claims) {
  if (claims == nullptr || device.role() != DeviceRole::motion) return {};
  if (const auto address = transport::parse_address(device.address))
    for (const auto& key : transport::keys_of(*address))
      DRIFTWISE_RETURN_IF_ERROR(claims->take(device.id, key));
  return {};
}

}  // namespace driftwise
