#pragma once
// The loop behind Instrument for one LDS1000. Use make_newport_lds1000.
//
// read() gives every [[device.angle]] in arcsec, sign applied. It asks the status before and after
// the values, for what the controller prints without a beam is not specified: only values between
// two good states count. start and end are cell time, for the controller has no clock. A value is
// the mean of the integration that ends when it is asked for: start is so much earlier, and read()
// waits until the integration lies behind the call, so that nothing of before it is in the value.
// At every connection the set-up of each axis is read: another unit or increment than the options
// name is refused, microradian is converted. A value does not say its unit, and a controller that
// was switched off and on has the one of its delivery: the set-up is read again behind every value.

#include "drivers/lds1000/lds_codec.h"
#include "drivers/lds1000/lds_options.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/instrument.h"

namespace driftwise::lds1000 {

class Autocollimator final : public transport::LineDevice<Instrument> {
 public:
  Autocollimator(DeviceDescription device, Options options, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock, SharedByAddress* shared = nullptr);

  // Errors besides those of every device: failed_precondition NO_SPOT (no light, too much of it,
  // or outside the range): the angle is absolute, so it is right again when the spot is back.
  // WRONG_SET_UP: an axis has another unit than before; the next call sets the controller up anew.
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<void>> set_integration();
  Awaitable<Result<void>> check_axis(std::size_t i);
  Awaitable<Result<SetUp>> ask_set_up(int axis);
  Awaitable<Result<void>> check_still_set_up(std::size_t i);
  Awaitable<Result<void>> check_spot();

  Options options_;
  std::vector<SetUp> set_ups_;  // per angle, of its axis
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::lds1000
