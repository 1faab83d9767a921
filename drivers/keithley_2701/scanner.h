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
#include "drivers/transport/link.h"
#include "drivers/transport/turn.h"
#include "server/core/ports/instrument.h"

namespace driftwise::keithley {

class Scanner final : public Instrument {
 public:
  Scanner(DeviceDescription device, Options options, const transport::Address& address,
          asio::any_io_executor executor, Clock& clock);

  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return link_.health(); }
  std::vector<std::string> recent_exchanges() const override { return link_.log().lines(); }
  Awaitable<Result<void>> prepare() override;
  void close() override { link_.close(); }
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> zero() override;  // NO_ZERO

 private:
  Awaitable<Result<void>> get_ready();
  Awaitable<Result<void>> set_up();
  Awaitable<Result<void>> configure();
  Awaitable<Result<void>> compare_scan_list();
  Awaitable<Result<void>> drain_errors();
  Awaitable<Result<void>> tell(std::string command);
  Awaitable<Result<std::string>> ask(std::string query);
  Result<Reading> reading_from(const std::string& reply, CellTime asked);
  tl::unexpected<Error> nonsense(const Error& error);
  double channel_s() const;

  DeviceDescription device_;
  Options options_;
  Clock& clock_;
  std::vector<int> scanned_;  // ascending: the order in which the scanner goes through them
  Nanoseconds timeout_, scan_timeout_;
  std::string identity_;
  transport::Link link_;
  transport::Turn turn_;
  transport::ClockAnchor anchor_;
  std::optional<Layout> layout_;
  std::int64_t set_up_generation_ = 0;
  std::int64_t sequence_ = 0;
};

}  // namespace driftwise::keithley
