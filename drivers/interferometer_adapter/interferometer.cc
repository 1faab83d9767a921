#include "drivers/interferometer_adapter/interferometer.h"

#include <cstdio>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::adapter {
namespace {

constexpr std::int64_t kLostZero = -1;  // no connection has this number

}  // namespace

Interferometer::Interferometer(DeviceDescription device, Options options,
                               const transport::Address& address, asio::any_io_executor executor,
                               Clock& clock, SharedByAddress* shared)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.resync_request = "IDN?\n", .answers_each_connection = true}, shared),
      options_(std::move(options)),
      length_channel_(device_.length()->channel.name()),
      std_channel_(device_.length()->channel.symbol + "_std_nm"),
      measure_timeout_(timeout_ +
                       nanoseconds_from_s(2 * options_.samples / options_.sample_rate_hz)) {}

DeviceHealth Interferometer::health() const {
  DeviceHealth health = link_.health();
  health.clock_offset = clock_of_device_.offset();
  health.max_clock_offset_s = options_.max_clock_offset_s;
  health.clock_jumps = clock_jumps_;
  health.last_clock_jump = last_clock_jump_;
  return health;
}

Awaitable<Result<void>> Interferometer::set_up() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("IDN?"));
  const auto identity = parse_identity(reply);
  if (!identity) co_return link_.wrong_reply(identity.error());
  if (options_.channel > identity->channels) {
    co_return link_.refused(reasons::kNoChannel,
                            "option channel = " + std::to_string(options_.channel) +
                                ", the adapter has " + std::to_string(identity->channels));
  }
  know_identity(identity->text, reply);
  // After an answer that only came too late the set-up still stands. Sent again, it would hide that
  // it was lost, and the zero with it: the number of samples shows that.
  if (!is_new_connection() && !has_forgotten_) co_return Result<void>{};
  if (auto set = co_await command("AVG " + std::to_string(options_.samples)); !set) co_return set;
  if (auto set = co_await send_dead_path(); !set) co_return set;
  has_forgotten_ = false;
  co_return Result<void>{};
}

Awaitable<Result<void>> Interferometer::command(std::string line) {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask(std::move(line)));
  const auto accepted = parse_ok(reply);
  if (accepted) co_return Result<void>{};
  co_return wrong(accepted);
}

Awaitable<Result<void>> Interferometer::send_dead_path() {
  char line[64];
  std::snprintf(line, sizeof line, "DEADPATH %d %.9g", options_.channel, options_.dead_path_mm);
  co_return co_await command(line);
}

Awaitable<Result<void>> Interferometer::zero() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  if (auto set = co_await send_dead_path(); !set) co_return set;
  auto done = co_await command("ZERO " + std::to_string(1 << (options_.channel - 1)));
  if (done) zero_generation_ = link_.generation();
  co_return done;
}

Awaitable<Result<Reading>> Interferometer::read() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  if (zero_generation_ != 0 && zero_generation_ != link_.generation()) {
    co_return fail(
        ErrorCode::failed_precondition, reasons::kBeamLost,
        "device '" + device_.id + "' at " + device_.address +
            ": the line broke since the last zero, or the set-up got lost, and the adapter "
            "may have been restarted: zero again");
  }
  const CellTime asked = clock_.now().utc;
  DRIFTWISE_CO_TRY(
      const auto reply,
      co_await link_.ask("MEAS? " + std::to_string(options_.channel) + "\n", measure_timeout_));
  auto measurement = parse_measurement(reply);
  if (measurement && measurement->channel != options_.channel) {
    measurement = fail(ErrorCode::data_loss, reasons::kBadReply,
                       "expected ch=" + std::to_string(options_.channel));
  }
  if (measurement && measurement->samples != options_.samples) {
    measurement = fail(ErrorCode::data_loss, reasons::kBadReply,
                       "expected n=" + std::to_string(options_.samples) +
                           " as it was set up: it has forgotten its set-up");
    has_forgotten_ = true;
    link_.lose_set_up();
    if (zero_generation_ != 0) zero_generation_ = kLostZero;
  }
  if (!measurement) co_return wrong(measurement);
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
    return link_.wrong_reply({ErrorCode::data_loss, reasons::kClockJumped, text});
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
