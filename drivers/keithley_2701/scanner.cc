#include "drivers/keithley_2701/scanner.h"

#include <algorithm>

#include "drivers/keithley_2701/platinum_resistance.h"
#include "server/core/try.h"

namespace driftwise::keithley {
namespace {

transport::LinkSettings link_settings(const DeviceDescription& device, const Options& options,
                                      const std::string& identity) {
  transport::LinkSettings out;
  out.device = device.id;
  out.address = device.address;
  out.resync_prefix = "\x03";  // breaks the pending operation and drops its output
  out.resync_request = "*CLS" + options.send_end + "*IDN?" + options.send_end;
  out.is_resync_reply = [&identity](std::string_view reply) {
    return !identity.empty() && reply == identity;
  };
  return out;
}

std::vector<int> scanned_inputs(const DeviceDescription& device) {
  std::vector<int> out;
  for (const auto& probe : device.probes) out.push_back(probe.input);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Scanner::Scanner(DeviceDescription device, Options options, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock)
    : device_(std::move(device)),
      options_(std::move(options)),
      clock_(clock),
      scanned_(scanned_inputs(device_)),
      timeout_(nanoseconds_from_s(device_.timeout_s)),
      scan_timeout_(nanoseconds_from_s(2 * channel_s() * static_cast<double>(scanned_.size()) + 3)),
      link_(executor, clock, link_settings(device_, options_, identity_),
            transport::make_stream(executor, address, options_.serial)),
      turn_(executor) {}

// A four-wire, offset-compensated reading integrates four times (PROTOCOLS.md section 1).
double Scanner::channel_s() const {
  return 4 * options_.nplc / options_.mains_hz + options_.relay_s;
}

tl::unexpected<Error> Scanner::nonsense(const Error& error) {
  link_.lose_step();
  return link_.wrong_reply(error);
}

Awaitable<Result<void>> Scanner::tell(std::string command) {
  return link_.tell(command + options_.send_end, timeout_);
}
Awaitable<Result<std::string>> Scanner::ask(std::string query) {
  return link_.ask(query + options_.send_end, timeout_);
}

Awaitable<Result<void>> Scanner::prepare() {
  const auto turn = co_await turn_.take();
  co_return co_await get_ready();
}

Awaitable<Result<void>> Scanner::zero() {
  co_return fail(ErrorCode::failed_precondition, "NO_ZERO",
                 "device '" + device_.id + "': a scanner has no zero");
}

Awaitable<Result<Reading>> Scanner::read() {
  const auto turn = co_await turn_.take();
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
  for (const auto& probe : device_.probes) {
    const auto found = std::find_if(scan->begin(), scan->end(),
                                    [&](const auto& one) { return one.channel == probe.input; });
    out.values.push_back({probe.channel.name(),
                          platinum::degc_from_ohm(
                              found->value, {probe.r0_ohm, probe.a_per_degc, probe.b_per_degc2})});
  }
  return out;
}

}  // namespace driftwise::keithley
