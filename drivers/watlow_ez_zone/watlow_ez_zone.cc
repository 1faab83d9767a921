#include "drivers/watlow_ez_zone/watlow_ez_zone.h"

#include "drivers/transport/shared_line.h"
#include "drivers/watlow_ez_zone/peltier_stabiliser.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Stabiliser>> make_watlow_ez_zone(const DeviceDescription& device,
                                                        asio::any_io_executor executor,
                                                        Clock& clock, SharedByAddress* shared) {
  DRIFTWISE_TRY(const auto options, watlow::read_options(device));
  DRIFTWISE_TRY(auto address, transport::parse_address(device.address));
  const auto make_line = [&] { return std::make_shared<watlow::ModbusLine>(options.serial); };
  const bool is_bus = shared && std::holds_alternative<transport::SerialAddress>(address);
  auto line = is_bus ? shared->find_or<watlow::ModbusLine>(
                           transport::shared_key(address, device.address), make_line)
                     : make_line();
  if (!(line->serial == options.serial))
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "device '" + device.id +
                    "': options of the serial line (baud, parity, data_bits, stop_bits, flow): "
                    "expected the same as of the other device at " +
                    device.address + ": it is one line");
  return std::make_unique<watlow::PeltierStabiliser>(device, options, std::move(address),
                                                     std::move(line), std::move(executor), clock);
}

}  // namespace driftwise::drivers
