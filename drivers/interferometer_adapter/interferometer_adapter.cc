#include "drivers/interferometer_adapter/interferometer_adapter.h"

#include "drivers/interferometer_adapter/interferometer.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Instrument>> make_interferometer_adapter(const DeviceDescription& device,
                                                                asio::any_io_executor executor,
                                                                Clock& clock) {
  auto options = adapter::read_options(device);
  if (!options) return tl::unexpected(options.error());
  const auto address = transport::parse_address(device.address);
  if (!address) return tl::unexpected(address.error());
  if (!device.length || device.length->unit != "mm") {
    return fail(ErrorCode::invalid_argument, "NO_LENGTH",
                "device '" + device.id +
                    "' (interferometer-adapter): expected length = \"<symbol>_mm\", such as x_mm");
  }
  return std::make_unique<adapter::Interferometer>(device, std::move(*options), *address,
                                                   std::move(executor), clock);
}

}  // namespace driftwise::drivers
