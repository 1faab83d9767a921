#pragma once
// The loop behind Instrument for one touch probe on an ND 28x read-out, on a serial line or behind
// a serial server.
//
// read() gives the length in mm since the last zero(), sign applied: the mean of `readings` values,
// and <symbol>_std_nm of them where there are two or more. A tip that has lost its contact, or
// stands at an end of its way, is a state: the length is then missing (kMissing), not an error.
// zero() keeps the present value as the zero here and changes nothing in the read-out. A read-out
// that has lost its mains counts from where the tip was then, and looks as before: after an answer
// that did not come, or a new connection, the zero is lost (read() answers BEAM_LOST until the next
// zero()), unless the cell file says that the read-out's value stays absolute (keeps_value). Until
// the first zero() the length counts from the read-out's own 0. An answer that did not come in time
// is got rid of by a new connection: its first question is the identity, or, of a read-out that has
// none, is asked after a time-out's silence. start and end are cell time.

#include <optional>
#include <vector>

#include "drivers/touch_probe/nd28x_codec.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/instrument.h"

namespace driftwise::touch_probe {

// Options of the cell file: facts that the protocol leaves open, with their defaults.
struct Options {
  int readings = 4;
  int sign = 1;  // -1: the read-out counts down while the coordinate grows
  double contact_min_mm = -1000, contact_max_mm = 1000;  // of the read-out; beyond: no contact
  bool keeps_value = false;   // its value is the same after its mains were away
  bool asks_identity = true;  // false: a read-out without remote commands, as the ND 281B
  // 9600 7E1: the example of the ND 281B's manual.
  transport::SerialSettings serial{.data_bits = 7, .parity = transport::Parity::even};
};
// Errors: invalid_argument, BAD_OPTION.
Result<Options> read_options(const DeviceDescription& device);

class Nd28xProbe final : public transport::LineDevice<Instrument> {
 public:
  Nd28xProbe(DeviceDescription device, const Options& options, const transport::Address& address,
             asio::any_io_executor executor, Clock& clock, SharedByAddress* shared = nullptr);

  // Errors besides those of every device: failed_precondition INPUT_ERROR, WRONG_SET_UP, BEAM_LOST
  // (its zero is lost).
  Awaitable<Result<Reading>> read() override;
  // Errors besides: failed_precondition OUT_OF_RANGE: no contact, so there is nothing to zero.
  Awaitable<Result<void>> zero() override;
  bool knows_its_zero() const override { return zero_mm_.has_value(); }

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<std::vector<double>>> read_values_mm();
  // False where a value lies where the tip touches nothing.
  bool is_in_contact(const std::vector<double>& values_mm) const;

  Options options_;
  std::optional<double> zero_mm_;  // of the read-out; none: not zeroed since the start, or lost
  bool has_lost_zero_ = false;
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::touch_probe
