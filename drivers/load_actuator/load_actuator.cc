#include "drivers/load_actuator/load_actuator.h"

#include "drivers/load_actuator/weights.h"
#include "drivers/transport/options.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<LoadActuator>> make_load_actuator(const DeviceDescription& device,
                                                         asio::any_io_executor executor,
                                                         Clock& clock, SharedByAddress* shared) {
  DRIFTWISE_RETURN_IF_ERROR(transport::OptionReader(device).finish());
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  if (!device.force())
    return fail(ErrorCode::invalid_argument, reasons::kNoForce,
                "device '" + device.id + "' (load-actuator): expected channel = \"force_N\"");
  return std::make_unique<load_actuator::Weights>(device, address, std::move(executor), clock,
                                                  shared);
}

}  // namespace driftwise::drivers
