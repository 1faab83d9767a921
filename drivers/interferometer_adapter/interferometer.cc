#include "drivers/interferometer_adapter/interferometer.h"

#include <cstdio>

#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::adapter {
namespace {

transport::LinkSettings link_settings(const DeviceDescription& device,
                                      const std::string& identity_line) {
  transport::LinkSettings out;
  out.device = device.id;
  out.address = device.address;
  out.resync_request = "IDN?\n";
  out.is_resync_reply = [&identity_line](std::string_view reply) {
    return !identity_line.empty() && reply == identity_line;
  };
  return out;
}

// A refusal is in step with us, nonsense is not.
bool is_nonsense(const Error& error) { return error.reason == "BAD_REPLY"; }

}  // namespace

Interferometer::Interferometer(DeviceDescription device, Options options,
                               const transport::Address& address, asio::any_io_executor executor,
                               Clock& clock)
    : device_(std::move(device)),
      options_(std::move(options)),
      clock_(clock),
      length_channel_(device_.length->name()),
      std_channel_(device_.length->symbol + "_std_nm"),
      timeout_(nanoseconds_from_s(device_.timeout_s)),
      measure_timeout_(timeout_ +
                       nanoseconds_from_s(2 * options_.samples / options_.sample_rate_hz)),
      link_(executor, clock, link_settings(device_, identity_line_),
            transport::make_stream(executor, address, {})),
      turn_(executor) {}

DeviceHealth Interferometer::health() const {
  DeviceHealth health = link_.health();
  health.clock_offset = clock_of_device_.offset();
  health.max_clock_offset_s = options_.max_clock_offset_s;
  health.clock_jumps = clock_jumps_;
  health.last_clock_jump = last_clock_jump_;
  return health;
}

Awaitable<Result<void>> Interferometer::prepare() {
  const auto turn = co_await turn_.take();
  co_return co_await get_ready();
}

Awaitable<Result<void>> Interferometer::get_ready() {
  if (auto up = co_await link_.connect(timeout_); !up) co_return up;
  if (link_.generation() == set_up_generation_) co_return Result<void>{};
  auto done = co_await set_up();
  if (!done && link_.connected()) link_.drop(done.error().message);
  co_return done;
}

Awaitable<Result<void>> Interferometer::set_up() {
  identity_line_.clear();
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask("IDN?\n", timeout_));
  const auto identity = parse_identity(reply);
  if (!identity) co_return link_.wrong_reply(identity.error());
  if (options_.channel > identity->channels) {
    co_return link_.refused("NO_CHANNEL", "option channel = " + std::to_string(options_.channel) +
                                              ", the adapter has " +
                                              std::to_string(identity->channels));
  }
  identity_line_ = transport::without_line_ends(reply);
  link_.set_identity(identity->text);
  if (auto set = co_await command("AVG " + std::to_string(options_.samples)); !set) co_return set;
  if (auto set = co_await send_dead_path(); !set) co_return set;
  set_up_generation_ = link_.generation();
  co_return Result<void>{};
}

Awaitable<Result<void>> Interferometer::command(std::string line) {
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask(line + "\n", timeout_));
  const auto accepted = parse_ok(reply);
  if (accepted) co_return Result<void>{};
  if (is_nonsense(accepted.error())) link_.lose_step();
  co_return link_.wrong_reply(accepted.error());
}

Awaitable<Result<void>> Interferometer::send_dead_path() {
  char line[64];
  std::snprintf(line, sizeof line, "DEADPATH %d %.9g", options_.channel, options_.dead_path_mm);
  co_return co_await command(line);
}

Awaitable<Result<void>> Interferometer::zero() {
  const auto turn = co_await turn_.take();
  if (auto ready = co_await get_ready(); !ready) co_return ready;
  if (auto set = co_await send_dead_path(); !set) co_return set;
  auto done = co_await command("ZERO " + std::to_string(1 << (options_.channel - 1)));
  if (done) zero_generation_ = link_.generation();
  co_return done;
}

Awaitable<Result<Reading>> Interferometer::read() {
  const auto turn = co_await turn_.take();
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready());
  if (zero_generation_ != 0 && zero_generation_ != link_.generation()) {
    co_return fail(ErrorCode::failed_precondition, "BEAM_LOST",
                   "device '" + device_.id + "' at " + device_.address +
                       ": the line broke since the last zero and the adapter may have been "
                       "restarted: zero again");
  }
  const CellTime asked = clock_.now().utc;
  DRIFTWISE_CO_TRY(
      const auto reply,
      co_await link_.ask("MEAS? " + std::to_string(options_.channel) + "\n", measure_timeout_));
  auto measurement = parse_measurement(reply);
  if (measurement && measurement->channel != options_.channel) {
    measurement =
        fail(ErrorCode::data_loss, "BAD_REPLY", "expected ch=" + std::to_string(options_.channel));
  }
  if (measurement && measurement->samples != options_.samples) {
    measurement =
        fail(ErrorCode::data_loss, "BAD_REPLY", "expected n=" + std::to_string(options_.samples));
  }
  if (!measurement) {
    if (is_nonsense(measurement.error())) link_.lose_step();
    co_return link_.wrong_reply(measurement.error());
  }
  if (auto good = check_status(*measurement); !good) co_return link_.wrong_reply(good.error());
  co_return reading_from(*measurement, asked);
}

// The adapter's stamps are by its own clock: they count by their measured offset, whatever that is.
Result<Reading> Interferometer::reading_from(const Measurement& measurement, CellTime asked) {
  const auto jump = clock_of_device_.observe(measurement.start, measurement.end, asked,
                                             clock_.now().utc, clock_.speed());
  if (jump) {
    ++clock_jumps_;
    last_clock_jump_ = *jump;
    char text[160];
    std::snprintf(text, sizeof text,
                  "the adapter's clock was set by %+.3f s: this reading may lie on either side of "
                  "it and is not used; the next ones count by the new offset",
                  seconds_from(*jump));
    return link_.wrong_reply({ErrorCode::data_loss, "CLOCK_JUMPED", text});
  }
  Reading out;
  out.device = device_.id;
  out.start = clock_of_device_.cell_time(measurement.start);
  out.end = clock_of_device_.cell_time(measurement.end);
  out.sequence = ++sequence_;
  out.values.push_back({length_channel_, mm_from_nm(measurement.mean_nm)});
  out.values.push_back({std_channel_, measurement.std_nm});
  if (!options_.air_channel.empty()) {
    const bool fresh =
        measurement.air_age_s >= 0 && measurement.air_age_s <= options_.max_air_age_s;
    out.values.push_back({options_.air_channel, fresh ? measurement.air_degc : kMissing});
  }
  if (!options_.level_channel.empty())
    out.values.push_back({options_.level_channel, measurement.level_pct});
  return out;
}

}  // namespace driftwise::adapter
