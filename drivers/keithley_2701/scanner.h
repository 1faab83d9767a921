#pragma once
// The loop behind Instrument for one scanner. Use make_keithley_2701.
//
// One READ? per read(): all channels in one scan. Reading.start and end are the scanner's own time
// stamps of its first and last channel, brought to cell time by the exchange around them
// (transport/clock_anchor.h), widened at the front by the first channel's integration. A joined
// value belongs to their middle; a channel is at most half a scan (2..3 s) away from it, in which a
// machine part moves by far less than a millikelvin. After a time-out: device clear (0x03), *CLS,
// and the identity brings the line back in step; the set-up stays.

#include <vector>

#include "drivers/keithley_2701/scan_codec.h"
#include "drivers/keithley_2701/scan_options.h"
#include "drivers/transport/clock_anchor.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/instrument.h"

namespace driftwise::keithley {

class Scanner final : public transport::LineDevice<Instrument> {
 public:
  Scanner(DeviceDescription device, Options options, const transport::Address& address,
          asio::any_io_executor executor, Clock& clock);

  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;  // NO_ZERO

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<void>> configure();
  Awaitable<Result<void>> compare_scan_list();
  Awaitable<Result<void>> drain_errors();
  Result<Reading> reading_from(const std::string& reply, CellTime asked);
  tl::unexpected<Error> nonsense(const Error& error);
  double channel_s() const;

  Options options_;
  std::vector<int> scanned_;  // ascending: the order in which the scanner goes through them
  Nanoseconds scan_timeout_;
  transport::ClockAnchor anchor_;
  std::optional<Layout> layout_;
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::keithley
