#include "drivers/nut_ups/nut_ups.h"

#include <algorithm>
#include <cctype>

#include "drivers/transport/address.h"
#include "drivers/transport/options.h"
#include "server/core/data/reading.h"
#include "server/core/reasons.h"

namespace driftwise::nut_ups {

Result<Options> read_options(const DeviceDescription& device) {
  transport::OptionReader reader(device);
  Options out;
  out.ups = reader.text("ups", out.ups);
  const bool is_word = !out.ups.empty() && std::ranges::all_of(out.ups, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
  if (!is_word)
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "device '" + device.id +
                    "', option ups: expected the name of a section of ups.conf, such as rack1");
  DRIFTWISE_RETURN_IF_ERROR(reader.finish());
  return out;
}

NutUps::NutUps(DeviceDescription device, Options options, const transport::Address& address,
               asio::any_io_executor executor, Clock& clock)
    : LineDevice(
          std::move(device), address, std::move(executor), clock,
          {.end_of_command = "\n", .resync_request = "VER\n", .is_resync_reply = is_version}),
      options_(std::move(options)),
      symbol_(symbol_from_id(device_.id)) {}

Awaitable<Result<void>> NutUps::set_up() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("VER"));
  const auto version = transport::without_line_ends(reply);
  if (!is_version(version))
    co_return link_.wrong_reply({ErrorCode::failed_precondition, reasons::kWrongDevice,
                                 "expected upsd of Network UPS Tools"});
  know_identity(std::string(version), reply);
  co_return Result<void>{};
}

Awaitable<Result<std::optional<std::string>>> NutUps::value_of(std::string name) {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask(get_command(options_.ups, name)));
  auto value = parse_value(reply, options_.ups, name);
  if (!value) co_return wrong(value);
  co_return value;
}

// Real supplies say "-1" or nothing for a runtime (networkupstools/nut issue 983), and their status
// counts all the same.
Awaitable<Result<double>> NutUps::quantity(std::string name) {
  const auto text = co_await value_of(name);
  if (!text && text.error().code == ErrorCode::aborted) co_return tl::unexpected(text.error());
  if (!text || !*text) co_return kMissing;
  co_return parse_quantity(**text, name).value_or(kMissing);
}

Awaitable<Result<Reading>> NutUps::read() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  Reading out;
  out.device = device_.id;
  out.start = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto status, co_await value_of("ups.status"));
  const auto supply = parse_status(status.value_or(""));
  if (!supply) co_return wrong(supply);
  DRIFTWISE_CO_TRY(const double charge_pct, co_await quantity("battery.charge"));
  DRIFTWISE_CO_TRY(const double runtime_s, co_await quantity("battery.runtime"));
  out.end = clock_.now().utc;
  out.values = {{symbol_ + "_on_battery_1", supply->on_battery ? 1.0 : 0.0},
                {symbol_ + "_low_battery_1", about_to_go_.take(*supply) ? 1.0 : 0.0},
                {symbol_ + "_forced_1", supply->forced ? 1.0 : 0.0},
                {symbol_ + "_charge_pct", charge_pct},
                {symbol_ + "_runtime_s", runtime_s}};
  out.sequence = ++sequence_;
  co_return out;
}

Awaitable<Result<void>> NutUps::zero() {
  co_return transport::no_zero(device_, "a supply has no zero");
}

}  // namespace driftwise::nut_ups
