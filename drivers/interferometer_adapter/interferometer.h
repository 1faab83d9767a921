#pragma once
// The loop behind Instrument for one channel of an adapter. Use make_interferometer_adapter.
//
// read() gives <length> in mm, <symbol>_std_nm, the adapter's own air temperature and signal level,
// with the device's time stamps (t0, t1) as start and end. zero() sends DEADPATH, then ZERO. A line
// that broke since the last zero means that the adapter may have been restarted and may count from
// anywhere: read() then answers BEAM_LOST until the next zero(). So it does after a measurement
// that does not average as the adapter was told: it has lost its set-up without a new connection.

#include "drivers/interferometer_adapter/adapter_codec.h"
#include "drivers/interferometer_adapter/adapter_options.h"
#include "drivers/transport/device_clock.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/instrument.h"

namespace driftwise::adapter {

class Interferometer final : public transport::LineDevice<Instrument> {
 public:
  Interferometer(DeviceDescription device, Options options, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock, SharedByAddress* shared = nullptr);

  DeviceHealth health() const override;
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<void>> command(std::string line);
  Awaitable<Result<void>> send_dead_path();
  Result<Reading> reading_from(const Measurement& measurement, CellTime asked);

  Options options_;
  std::string length_channel_, std_channel_;
  Nanoseconds measure_timeout_;
  std::int64_t zero_generation_ = 0;  // 0: never zeroed by us; -1: lost with the set-up
  bool has_forgotten_ = false;        // the set-up of this connection
  std::int64_t sequence_ = 0;
  transport::DeviceClock clock_of_device_;
  std::int64_t clock_jumps_ = 0;
  Nanoseconds last_clock_jump_{0};
};

}  // namespace driftwise::adapter
