#include "drivers/keithley_2701/scanner.h"

#include <algorithm>

#include "server/core/data/reading.h"
#include "server/core/try.h"

namespace driftwise::keithley {

double Scan::value(int input) const {
  const auto found = std::ranges::find(readings, input, &ChannelReading::channel);
  return found == readings.end() ? kMissing : found->value;
}

Scanner::Scanner(DeviceDescription device, Options options, std::vector<ScanList> lists,
                 const transport::Address& address, asio::any_io_executor executor, Clock& clock)
    : LineDevice(std::move(device), address, executor, clock,
                 {.end_of_command = options.send_end,
                  .resync_request = "*IDN?" + options.send_end,
                  .resync_prefix = "\x03",  // breaks the pending operation and drops its output
                  .serial = options.serial}),
      options_(std::move(options)),
      lists_(std::move(lists)),
      is_on_serial_line_(std::holds_alternative<transport::SerialAddress>(address)),
      mutex_(executor) {}

// A four-wire, offset-compensated reading integrates four times; a voltage twice, with its autozero
// (M).
double Scanner::channel_s(const ScanList& list) const {
  const double times = list.function == ScanFunction::four_wire_ohms ? 4 : 2;
  return times * list.options.nplc / options_.mains_hz + options_.relay_s;
}

Nanoseconds Scanner::scan_timeout(const ScanList& list) const {
  return nanoseconds_from_s(2 * channel_s(list) * static_cast<double>(list.inputs.size()) + 3);
}

Nanoseconds Scanner::transmission(std::size_t bytes) const {
  constexpr double kBitsPerByte = 10;  // start, eight, stop
  if (!is_on_serial_line_) return Nanoseconds(0);
  return nanoseconds_from_s(kBitsPerByte * static_cast<double>(bytes) / options_.serial.baud);
}

DeviceHealth Scanner::health() const {
  auto out = LineDevice::health();
  if (errors_before_.empty()) return out;
  out.last_error += (out.last_error.empty() ? "" : "; ") +
                    ("its error queue before it was set up anew: " + errors_before_);
  return out;
}

tl::unexpected<Error> Scanner::nonsense(const Error& error) {
  link_.lose_step();
  link_.lose_set_up();
  return link_.wrong_reply(error);
}

Awaitable<Result<void>> Scanner::prepare() {
  const auto lock = co_await mutex_.lock();
  co_return co_await get_ready();
}

Awaitable<Result<Scan>> Scanner::scan(std::size_t number) {
  const auto lock = co_await mutex_.lock();
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready());
  const ScanList& list = lists_.at(number);
  if (selected_ != number) DRIFTWISE_CO_RETURN_IF_ERROR(co_await select(number));
  const CellTime asked = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto reply,
                   co_await link_.ask("READ?" + options_.send_end, scan_timeout(list)));
  co_return scan_from(reply, list, asked);
}

Result<Scan> Scanner::scan_from(const std::string& reply, const ScanList& list, CellTime asked) {
  const CellTime answered = clock_.now().utc;
  const auto fields = parse_fields(reply, Layout{}.fields * list.inputs.size());
  if (!fields) return nonsense(fields.error());
  if (!layout_) {
    const auto layout = learn_layout(*fields, list.inputs);
    if (!layout) return nonsense(layout.error());
    layout_ = *layout;
  }
  auto readings = read_scan(*fields, *layout_, list.inputs);
  if (!readings) return nonsense(readings.error());

  const auto [first, last] =
      std::minmax_element(readings->begin(), readings->end(),
                          [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  anchor_.observe(first->time_s, last->time_s, asked, answered);
  Scan out;
  out.start =
      std::max(anchor_.cell_time(first->time_s) - nanoseconds_from_s(channel_s(list)), asked);
  out.end = std::clamp(anchor_.cell_time(last->time_s), out.start, std::max(out.start, answered));
  out.readings = std::move(*readings);
  return out;
}

}  // namespace driftwise::keithley
