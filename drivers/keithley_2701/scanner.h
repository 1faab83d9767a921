#pragma once
// One scanner behind its one connection, whatever the devices of the cell file read with it: lists
// of inputs in four-wire ohms or in volts. Use make_keithley_2701.
//
// One READ? per scan(): all inputs of one list. Start and end of a scan are the scanner's own time
// stamps of its first and last channel, brought to cell time by the exchange around them
// (transport/clock_anchor.h), widened at the front by the first channel's integration. A joined
// value belongs to their middle; a channel is at most half a scan (2..3 s) away from it, in which a
// machine part moves by far less than a millikelvin. After a time-out: device clear (0x03) and the
// identity bring the line back in step. Then it is set up anew, as after a scan that has other
// fields or channels than were asked for: on a serial line a scanner that lost its mains comes back
// with the settings of its delivery, without a new connection and with the same identity. What its
// error queue says of before is read first and is part of the health's text until the next set-up.
//
// Several devices share it, and the caller's mutual exclusion is per device: the connection's own
// is here. A list is selected before it is scanned, unless it was scanned last.

#include <optional>
#include <string>
#include <vector>

#include "drivers/keithley_2701/scan_codec.h"
#include "drivers/keithley_2701/scan_options.h"
#include "drivers/transport/clock_anchor.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/async_mutex.h"
#include "server/core/ports/device.h"

namespace driftwise::keithley {

enum class ScanFunction { four_wire_ohms, dc_volts };

// Channels that one device of the cell file scans.
struct ScanList {
  std::string device;  // id in the cell file
  ScanFunction function = ScanFunction::four_wire_ohms;
  std::vector<int> inputs;  // ascending: the order in which the scanner goes through them
  Options options;          // integration and range of this list
};

struct Scan {
  CellTime start, end;
  std::vector<ChannelReading> readings;
  double value(int input) const;  // kMissing: no such input
};

class Scanner final : public transport::LineDevice<Device> {
 public:
  // device, options: of the connection. lists: one per device, at least one.
  Scanner(DeviceDescription device, Options options, std::vector<ScanList> lists,
          const transport::Address& address, asio::any_io_executor executor, Clock& clock);

  Awaitable<Result<void>> prepare() override;
  DeviceHealth health() const override;
  // list: its place among the lists. Errors besides those of every device: data_loss BAD_REPLY,
  // UNKNOWN_LAYOUT, WRONG_CHANNEL.
  Awaitable<Result<Scan>> scan(std::size_t list);

 private:
  Awaitable<Result<void>> set_up() override;
  Awaitable<Result<void>> configure();
  Awaitable<Result<void>> select(std::size_t list);
  Awaitable<Result<void>> compare_scan_list(const ScanList& list);
  // Commands, and the wait until the scanner has executed them.
  Awaitable<Result<void>> execute(std::vector<std::string> commands);
  Awaitable<Result<std::string>> read_errors();  // of its queue; empty: none
  Awaitable<Result<void>> check_errors();
  Result<Scan> scan_from(const std::string& reply, const ScanList& list, CellTime asked);
  tl::unexpected<Error> nonsense(const Error& error);
  double channel_s(const ScanList& list) const;
  Nanoseconds scan_timeout(const ScanList& list) const;
  Nanoseconds transmission(std::size_t bytes) const;  // of a request; none on TCP

  Options options_;
  std::vector<ScanList> lists_;
  const bool is_on_serial_line_;
  AsyncMutex mutex_;
  transport::ClockAnchor anchor_;
  std::optional<Layout> layout_;
  std::optional<std::size_t> selected_;  // none: not known
  std::string errors_before_;            // of the queue, read at the last set-up
};

}  // namespace driftwise::keithley
