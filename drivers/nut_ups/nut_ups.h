#pragma once
// The loop behind Instrument for one uninterruptible supply behind upsd (Network UPS Tools).
//
// read() gives <id>_on_battery_1, <id>_low_battery_1 (power is about to go) and <id>_forced_1 (0 or
// 1), <id>_charge_pct and <id>_runtime_s (kMissing where the supply does not say, or says nothing
// usable: only the status may fail a reading). start and end are cell time.

#include "drivers/nut_ups/nut_codec.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/instrument.h"

namespace driftwise::nut_ups {

struct Options {
  std::string ups = "ups";  // its name in upsd's ups.conf
};
// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

class NutUps final : public transport::LineDevice<Instrument> {
 public:
  NutUps(DeviceDescription device, Options options, const transport::Address& address,
         asio::any_io_executor executor, Clock& clock);

  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;  // NO_ZERO

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<std::optional<std::string>>> value_of(std::string name);
  // kMissing: no usable value. Errors: aborted.
  Awaitable<Result<double>> quantity(std::string name);

  Options options_;
  std::string symbol_;
  AboutToGo about_to_go_;
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::nut_ups
