#include "drivers/keithley_2701/scanner.h"

#include <algorithm>

#include "drivers/keithley_2701/platinum_resistance.h"
#include "server/core/try.h"

namespace driftwise::keithley {
namespace {

std::vector<int> scanned_inputs(const DeviceDescription& device) {
  std::vector<int> out;
  for (const auto& probe : device.probes()) out.push_back(probe.input);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Scanner::Scanner(DeviceDescription device, Options options, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.end_of_command = options.send_end,
                  .resync_request = "*CLS" + options.send_end + "*IDN?" + options.send_end,
                  .resync_prefix = "\x03",  // breaks the pending operation and drops its output
                  .serial = options.serial}),
      options_(std::move(options)),
      scanned_(scanned_inputs(device_)),
      scan_timeout_(
          nanoseconds_from_s(2 * channel_s() * static_cast<double>(scanned_.size()) + 3)) {}

// A four-wire, offset-compensated reading integrates four times (PROTOCOLS.md section 1).
double Scanner::channel_s() const {
  return 4 * options_.nplc / options_.mains_hz + options_.relay_s;
}

tl::unexpected<Error> Scanner::nonsense(const Error& error) {
  link_.lose_step();
  return link_.wrong_reply(error);
}

Awaitable<Result<void>> Scanner::zero() {
  co_return transport::no_zero(device_, "a scanner has no zero");
}

Awaitable<Result<Reading>> Scanner::read() {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready());
  const CellTime asked = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto reply,
                   co_await link_.ask("READ?" + options_.send_end, scan_timeout_));
  co_return reading_from(reply, asked);
}

Result<Reading> Scanner::reading_from(const std::string& reply, CellTime asked) {
  const CellTime answered = clock_.now().utc;
  const auto fields = parse_fields(reply, Layout{}.fields * scanned_.size());
  if (!fields) return nonsense(fields.error());
  if (!layout_) {
    const auto layout = learn_layout(*fields, scanned_);
    if (!layout) return nonsense(layout.error());
    layout_ = *layout;
  }
  const auto scan = read_scan(*fields, *layout_, scanned_);
  if (!scan) return nonsense(scan.error());

  const auto [first, last] = std::minmax_element(
      scan->begin(), scan->end(), [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  anchor_.observe(first->time_s, last->time_s, asked, answered);
  Reading out;
  out.device = device_.id;
  out.start = std::max(anchor_.cell_time(first->time_s) - nanoseconds_from_s(channel_s()), asked);
  out.end = std::clamp(anchor_.cell_time(last->time_s), out.start, std::max(out.start, answered));
  out.sequence = ++sequence_;
  for (const auto& probe : device_.probes()) {
    const auto found = std::find_if(scan->begin(), scan->end(),
                                    [&](const auto& one) { return one.channel == probe.input; });
    out.values.push_back({probe.channel.name(),
                          platinum::degc_from_ohm(
                              found->value, {probe.r0_ohm, probe.a_per_degc, probe.b_per_degc2})});
  }
  return out;
}

}  // namespace driftwise::keithley
