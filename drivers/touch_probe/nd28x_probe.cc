#include "drivers/touch_probe/nd28x_probe.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/transport/address.h"
#include "drivers/transport/options.h"
#include "server/core/reasons.h"
#include "server/core/units.h"

namespace driftwise::touch_probe {
namespace {

// About the first value: means of mm must keep their nanometres.
double mean_mm(const std::vector<double>& values_mm) {
  double sum_mm = 0;
  for (const double value : values_mm) sum_mm += value - values_mm.front();
  return values_mm.front() + sum_mm / static_cast<double>(values_mm.size());
}

double spread_nm(const std::vector<double>& values_mm) {
  const double mean = mean_mm(values_mm);
  double squares = 0;
  for (const double value : values_mm) squares += (value - mean) * (value - mean);
  return nm_from_mm(std::sqrt(squares / static_cast<double>(values_mm.size() - 1)));
}

}  // namespace

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.readings = reader.integer("readings", out.readings, 1, 100);
  out.sign = reader.choice("direction", "up", {"up", "down"}) == "up" ? 1 : -1;
  out.contact_min_mm = reader.number("contact_min_mm", out.contact_min_mm, -1000, 1000);
  out.contact_max_mm = reader.number("contact_max_mm", out.contact_max_mm, -1000, 1000);
  out.keeps_value = reader.on_off("keeps_value", out.keeps_value);
  out.asks_identity = reader.on_off("identity", out.asks_identity);
  out.serial = transport::read_serial_settings(reader, out.serial);
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  if (!(out.contact_min_mm < out.contact_max_mm))
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "device '" + device.id +
                    "': option contact_min_mm is not below contact_max_mm: give the read-out's "
                    "values between which the tip touches");
  return out;
}

Nd28xProbe::Nd28xProbe(DeviceDescription device, const Options& options,
                       const transport::Address& address, asio::any_io_executor executor,
                       Clock& clock, SharedByAddress* shared)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.end_of_command = "", .resync_request = "", .serial = options.serial}, shared),
      options_(options) {}

Awaitable<Result<void>> Nd28xProbe::set_up() {
  if (zero_mm_ && !options_.keeps_value) {
    zero_mm_.reset();
    has_lost_zero_ = true;
  }
  // An identity is told from a value. Without one a value may be the answer to a question of
  // before, which a serial server gives to whoever is connected.
  if (!options_.asks_identity) co_return co_await link_.await_silence(timeout_);
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask(kAskIdentity, timeout_, kIdentityLines));
  const auto identity = parse_identity(reply);
  if (!identity) co_return wrong(identity);
  know_identity(*identity, "");
  co_return Result<void>{};
}

Awaitable<Result<std::vector<double>>> Nd28xProbe::read_values_mm() {
  std::vector<double> values_mm;
  for (int k = 0; k < options_.readings; ++k) {
    DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask(kAskValue, timeout_));
    const auto value_mm = parse_value(reply);
    if (!value_mm) co_return wrong(value_mm);
    values_mm.push_back(*value_mm);
  }
  co_return values_mm;
}

bool Nd28xProbe::is_in_contact(const std::vector<double>& values_mm) const {
  return std::ranges::all_of(values_mm, [this](double value_mm) {
    return value_mm > options_.contact_min_mm && value_mm < options_.contact_max_mm;
  });
}

Awaitable<Result<Reading>> Nd28xProbe::read() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  if (has_lost_zero_)
    co_return fail(ErrorCode::failed_precondition, reasons::kBeamLost,
                   "device '" + device_.id + "' at " + device_.address +
                       ": an answer did not come or the line broke since the last zero, and the "
                       "read-out may have lost its mains: zero again (option keeps_value = \"on\": "
                       "its value is absolute, also after that)");
  Reading out;
  out.device = device_.id;
  out.start = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto values_mm, co_await read_values_mm());
  out.end = clock_.now().utc;
  const auto& length = device_.length()->channel;
  const bool touches = is_in_contact(values_mm);
  out.values.push_back(
      {length.name(),
       touches ? options_.sign * (mean_mm(values_mm) - zero_mm_.value_or(0)) : kMissing});
  if (options_.readings > 1)
    out.values.push_back({length.symbol + "_std_nm", touches ? spread_nm(values_mm) : kMissing});
  out.sequence = ++sequence_;
  co_return out;
}

Awaitable<Result<void>> Nd28xProbe::zero() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  DRIFTWISE_CO_TRY(const auto values_mm, co_await read_values_mm());
  if (!is_in_contact(values_mm)) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "asked to zero, the read-out shows %+.5f mm, in contact it shows %g .. %g mm: "
                  "bring the tip into contact",
                  values_mm.back(), options_.contact_min_mm, options_.contact_max_mm);
    co_return link_.refused(reasons::kOutOfRange, text);
  }
  zero_mm_ = mean_mm(values_mm);
  has_lost_zero_ = false;
  co_return Result<void>{};
}

}  // namespace driftwise::touch_probe
