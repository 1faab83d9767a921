#include "drivers/keithley_2701/keithley_2701.h"

#include "drivers/keithley_2701/scanned_device.h"
#include "drivers/keithley_2701/voltage_instrument.h"
#include "drivers/transport/shared_line.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::drivers {

Result<std::unique_ptr<Instrument>> make_keithley_2701(const DeviceDescription& device,
                                                       asio::any_io_executor executor, Clock& clock,
                                                       SharedByAddress* shared) {
  DRIFTWISE_TRY(const auto address, transport::parse_address(device.address));
  DRIFTWISE_TRY(
      auto options,
      keithley::read_options(device, std::holds_alternative<transport::SerialAddress>(address)));
  const bool measures_volts = !device.voltages.sensors.empty();
  keithley::ScanList list{
      device.id,
      measures_volts ? keithley::ScanFunction::dc_volts : keithley::ScanFunction::four_wire_ohms,
      {},
      std::move(options)};
  for (const auto& probe : device.probes()) list.inputs.push_back(probe.input);
  for (const auto& sensor : device.voltages.sensors) list.inputs.push_back(sensor.input);
  if (list.inputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kBadProbes,
                "device '" + device.id +
                    "' (keithley-2701) has no [[device.probe]] and no "
                    "[[device.sensor]]");
  const auto make_share = [&] {
    return std::make_shared<keithley::ScannerShare>(address, executor, clock);
  };
  auto share = shared ? shared->find_or<keithley::ScannerShare>(
                            transport::shared_key(address, device.address), make_share)
                      : make_share();
  DRIFTWISE_RETURN_IF_ERROR(share->add(device, std::move(list)));
  using Made = std::unique_ptr<Instrument>;
  if (device.voltages.motor)
    return Made(std::make_unique<keithley::MotorForceInstrument>(device, std::move(share)));
  if (measures_volts)
    return Made(std::make_unique<keithley::VoltageInstrument>(device, std::move(share)));
  return Made(std::make_unique<keithley::Thermometers>(device, std::move(share)));
}

}  // namespace driftwise::drivers
