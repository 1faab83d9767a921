#pragma once
// The loop behind Instrument for one LDS1000. Use make_newport_lds1000.
//
// read() gives every [[device.angle]] in arcsec, sign applied. It asks the status before and after
// the values, for what the controller prints without a beam is not specified: only values between
// two good states count. start and end are cell time, for the controller has no clock. At every
// connection the set-up of each axis is read: another unit or increment than the options name is
// refused, microradian is converted.

#include "drivers/lds1000/lds_codec.h"
#include "drivers/lds1000/lds_options.h"
#include "drivers/transport/link.h"
#include "drivers/transport/turn.h"
#include "server/core/ports/instrument.h"

namespace driftwise::lds1000 {

class Autocollimator final : public Instrument {
 public:
  Autocollimator(DeviceDescription device, Options options, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock);

  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return link_.health(); }
  std::vector<std::string> recent_exchanges() const override { return link_.log().lines(); }
  Awaitable<Result<void>> prepare() override;
  void close() override { link_.close(); }
  // Errors besides those of every device: failed_precondition NO_SPOT (no light, too much of it,
  // or outside the range): the angle is absolute, so it is right again when the spot is back.
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;

 private:
  Awaitable<Result<void>> get_ready();
  Awaitable<Result<void>> set_up();
  Awaitable<Result<void>> set_integration();
  Awaitable<Result<void>> check_axis(std::size_t i);
  Awaitable<Result<void>> check_spot();
  Awaitable<Result<std::string>> ask(std::string command);
  template <class T>
  tl::unexpected<Error> wrong(const Result<T>& parsed);

  DeviceDescription device_;
  Options options_;
  Clock& clock_;
  Nanoseconds timeout_;
  std::string identity_line_;  // brings the line back in step
  std::vector<Unit> units_;    // per angle, as its axis is set up
  transport::Link link_;
  transport::Turn turn_;
  std::int64_t set_up_generation_ = 0, sequence_ = 0;
};

}  // namespace driftwise::lds1000
