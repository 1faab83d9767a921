#pragma once
// The loop behind Instrument for one inclinometer on a serial line, or behind a serial server.
//
// read() gives every [[device.angle]] in arcsec, sign applied: the mean of `readings` pairs. start
// and end are cell time, for the instrument has no clock. At every connection its stream is
// stopped, for it streams after power on; what was under way is dropped up to the identity.

#include "drivers/inclinometer/dpl_codec.h"
#include "drivers/transport/line_device.h"
#include "server/core/devices/settings_reader.h"
#include "server/core/ports/instrument.h"

namespace driftwise::inclinometer {

// Options of the cell file: facts that the protocol leaves open, with their defaults.
struct Options {
  int readings = 4;       // pairs that are averaged: the last digit is 0.001 deg, 3.6 arcsec
  double range_deg = 30;  // of the model: beyond it what is sent is not specified (U)
  transport::SerialSettings serial{.baud = 9600};  // 8N1 (U)
};
// Angles, whose range is the option range_deg; a wrong option is the driver's matter.
void read_settings(SettingsReader& reader, DeviceDescription& device);
// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

class DplInclinometer final : public transport::LineDevice<Instrument> {
 public:
  DplInclinometer(DeviceDescription device, const Options& options,
                  const transport::Address& address, asio::any_io_executor executor, Clock& clock,
                  SharedByAddress* shared = nullptr);

  // Errors besides those of every device: failed_precondition OUT_OF_RANGE: it lies too steep.
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;  // NO_ZERO

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<Tilt>> read_tilt();

  Options options_;
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::inclinometer
