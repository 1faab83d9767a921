#include "drivers/inclinometer/dpl_inclinometer.h"

#include <cmath>
#include <cstdio>

#include "drivers/transport/address.h"
#include "drivers/transport/options.h"
#include "server/core/devices/role_settings.h"
#include "server/core/reasons.h"

namespace driftwise::inclinometer {
namespace {

constexpr double kArcsecPerDeg = 3600;  // by definition
constexpr int kLines = 2;               // of every answer

}  // namespace

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.readings = reader.integer("readings", out.readings, 1, 100);
  out.range_deg = reader.number("range_deg", out.range_deg, 0.1, 180);
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

void read_settings(SettingsReader& reader, DeviceDescription& device) {
  read_angle_settings(reader, device);
  const auto options = read_options(device);
  device.become<AngleSettings>().range_arcsec =
      kArcsecPerDeg * options.value_or(Options{}).range_deg;
}

DplInclinometer::DplInclinometer(DeviceDescription device, const Options& options,
                                 const transport::Address& address, asio::any_io_executor executor,
                                 Clock& clock, SharedByAddress* shared)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.end_of_command = "",
                  .resync_request = "V",
                  .resync_prefix = "s",
                  .serial = options.serial,
                  .is_resync_reply = ends_identity},
                 shared),
      options_(options) {}

Awaitable<Result<void>> DplInclinometer::set_up() {
  link_.lose_step();  // it streams: stopped, and dropped up to an identity, before the question
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask("V", timeout_, kLines));
  const auto identity = parse_identity(reply);
  if (!identity) co_return wrong(identity);
  know_identity(*identity, reply);
  co_return Result<void>{};
}

Awaitable<Result<Tilt>> DplInclinometer::read_tilt() {
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask("R", timeout_, kLines));
  const auto tilt = parse_tilt(reply);
  if (!tilt) co_return wrong(tilt);
  if (std::abs(tilt->x_deg) > options_.range_deg || std::abs(tilt->y_deg) > options_.range_deg) {
    char text[120];
    std::snprintf(text, sizeof text, "tilt X %+.3f deg, Y %+.3f deg, range +-%g deg: level it",
                  tilt->x_deg, tilt->y_deg, options_.range_deg);
    co_return link_.refused(reasons::kOutOfRange, text);
  }
  co_return *tilt;
}

Awaitable<Result<Reading>> DplInclinometer::read() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  Reading out;
  out.device = device_.id;
  out.start = clock_.now().utc;
  Tilt sum;
  for (int k = 0; k < options_.readings; ++k) {
    DRIFTWISE_CO_TRY(const auto tilt, co_await read_tilt());
    sum.x_deg += tilt.x_deg;
    sum.y_deg += tilt.y_deg;
  }
  out.end = clock_.now().utc;
  for (const auto& angle : device_.angles()) {
    const double mean_deg = (angle.device_axis == 1 ? sum.x_deg : sum.y_deg) / options_.readings;
    out.values.push_back({angle.channel.name(), angle.sign * mean_deg * kArcsecPerDeg});
  }
  out.sequence = ++sequence_;
  co_return out;
}

Awaitable<Result<void>> DplInclinometer::zero() {
  co_return transport::no_zero(device_, "an inclinometer counts from the vertical");
}

}  // namespace driftwise::inclinometer
