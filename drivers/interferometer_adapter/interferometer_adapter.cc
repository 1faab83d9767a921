#include "drivers/interferometer_adapter/interferometer_adapter.h"

#include "drivers/interferometer_adapter/interferometer.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Instrument>> make_interferometer_adapter(const DeviceDescription& device,
                                                                asio::any_io_executor executor,
                                                                Clock& clock,
                                                                SharedByAddress* shared) {
  DRIFTWISE_TRY(auto options, adapter::read_options(device));
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  if (!device.length() || device.length()->channel.unit != "mm") {
    return fail(ErrorCode::invalid_argument, reasons::kNoLength,
                "device '" + device.id +
                    "' (interferometer-adapter): expected length = \"<symbol>_mm\", such as x_mm");
  }
  return std::make_unique<adapter::Interferometer>(device, std::move(options), address,
                                                   std::move(executor), clock, shared);
}

}  // namespace driftwise::drivers
