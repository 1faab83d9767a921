#include "drivers/keithley_2701/keithley_2701.h"

#include <set>

#include "drivers/keithley_2701/scanner.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Instrument>> make_keithley_2701(const DeviceDescription& device,
                                                       asio::any_io_executor executor,
                                                       Clock& clock) {
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  DRIFTWISE_TRY(
      auto options,
      keithley::read_options(device, std::holds_alternative<transport::SerialAddress>(address)));
  std::set<int> inputs;
  for (const auto& probe : device.probes()) {
    if (probe.input < 101 || probe.input > 599 || !inputs.insert(probe.input).second) {
      return fail(ErrorCode::invalid_argument, reasons::kBadProbes,
                  "device '" + device.id + "': probe " + probe.channel.name() + " on input " +
                      std::to_string(probe.input) + ": expected 101 .. 599, each once");
    }
  }
  if (inputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kBadProbes,
                "device '" + device.id + "' (keithley-2701) has no [[probes]]");
  return std::make_unique<keithley::Scanner>(device, std::move(options), address,
                                             std::move(executor), clock);
}

}  // namespace driftwise::drivers
