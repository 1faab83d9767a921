#include "drivers/lds1000/newport_lds1000.h"

#include "drivers/lds1000/autocollimator.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Instrument>> make_newport_lds1000(const DeviceDescription& device,
                                                         asio::any_io_executor executor,
                                                         Clock& clock, SharedByAddress* shared) {
  DRIFTWISE_TRY(auto options, lds1000::read_options(device));
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  if (device.angles().empty())
    return fail(
        ErrorCode::invalid_argument, reasons::kNoAngle,
        "device '" + device.id + "' (newport-lds1000): expected at least one [[device.angle]]");
  return std::make_unique<lds1000::Autocollimator>(device, std::move(options), address,
                                                   std::move(executor), clock, shared);
}

}  // namespace driftwise::drivers
