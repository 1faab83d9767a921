#include "drivers/lds1000/autocollimator.h"

#include <cmath>
#include <cstdio>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::lds1000 {
namespace {

std::string set_up_text(const SetUp& set_up) {
  char text[64];
  std::snprintf(text, sizeof text, "unit %s, increment %g", name_of(set_up.unit), set_up.increment);
  return text;
}

}  // namespace

Autocollimator::Autocollimator(DeviceDescription device, Options options,
                               const transport::Address& address, asio::any_io_executor executor,
                               Clock& clock, SharedByAddress* shared)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.end_of_command = options.end_of_command,
                  .resync_request = "VE" + options.end_of_command,
                  .serial = options.serial},
                 shared),
      options_(std::move(options)),
      set_ups_(device_.angles().size()) {}

Awaitable<Result<void>> Autocollimator::set_up() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("VE"));
  const auto version = parse_version(reply);
  if (!version) co_return wrong(version);
  know_identity(*version, reply);
  // Only the last error is kept: an old one must not be taken for an answer to what follows.
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await ask("TE"));
  if (auto set = co_await set_integration(); !set) co_return set;
  for (std::size_t i = 0; i < device_.angles().size(); ++i)
    if (auto good = co_await check_axis(i); !good) co_return good;
  co_return Result<void>{};
}

Awaitable<Result<void>> Autocollimator::set_integration() {
  auto setting = "KI" + std::to_string(options_.integration_ms);
  if (auto told = co_await tell(std::move(setting)); !told) co_return told;
  DRIFTWISE_CO_TRY(const auto taken, co_await ask("TE"));
  if (const auto error = parse_error(taken); !error) co_return wrong(error);
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("XI"));
  const auto found_ms = parse_integration_ms(reply);
  if (!found_ms) co_return wrong(found_ms);
  if (*found_ms != options_.integration_ms)
    co_return link_.refused(
        reasons::kNotSet, "the integration constant is " + std::to_string(*found_ms) +
                              " ms after it was set to " + std::to_string(options_.integration_ms));
  co_return Result<void>{};
}

Awaitable<Result<SetUp>> Autocollimator::ask_set_up(int axis) {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask(std::to_string(axis) + "TA"));
  auto found = parse_set_up(reply, axis);
  if (!found) co_return wrong(found);
  co_return found;
}

Awaitable<Result<void>> Autocollimator::check_axis(std::size_t i) {
  const int axis = device_.angles()[i].device_axis;
  DRIFTWISE_CO_TRY(const SetUp found, co_await ask_set_up(axis));
  const SetUp expected{options_.unit.value_or(found.unit),
                       options_.increment.value_or(found.increment)};
  if (found != expected)
    co_return link_.refused(reasons::kWrongSetUp,
                            "axis " + std::to_string(axis) + " is set up in " + set_up_text(found) +
                                ", the cell file expects " + set_up_text(expected) +
                                ": change one of the two");
  set_ups_[i] = found;
  co_return Result<void>{};
}

Awaitable<Result<void>> Autocollimator::check_still_set_up(std::size_t i) {
  const int axis = device_.angles()[i].device_axis;
  DRIFTWISE_CO_TRY(const SetUp found, co_await ask_set_up(axis));
  if (found == set_ups_[i]) co_return Result<void>{};
  link_.lose_set_up();
  co_return link_.refused(reasons::kWrongSetUp,
                          "axis " + std::to_string(axis) + " is set up in " + set_up_text(found) +
                              ", it was " + set_up_text(set_ups_[i]) +
                              " when the controller was set up: it was switched off and on, or "
                              "somebody changed it. This value is not used; the next reading sets "
                              "the controller up anew");
}

Awaitable<Result<void>> Autocollimator::check_spot() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("MS"));
  const auto status = parse_status(reply);
  if (!status) co_return wrong(status);
  if (status->usable()) co_return Result<void>{};
  co_return link_.refused(reasons::kNoSpot,
                          status->wrong_power
                              ? "wrong power received: free the beam, clean the mirror"
                              : "the spot is outside the range: align the mirror");
}

Awaitable<Result<Reading>> Autocollimator::read() {
  const CellTime called = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_spot());
  // A value is the mean of the integration that ends when it is asked for. The axes may have come
  // to rest just before the reading was asked for, and no gate behind it compares the two.
  const Nanoseconds integration = std::chrono::milliseconds(options_.integration_ms);
  co_await clock_.sleep_until(called + integration);
  Reading out;
  out.device = device_.id;
  out.start = clock_.now().utc - integration;
  for (std::size_t i = 0; i < device_.angles().size(); ++i) {
    const auto& angle = device_.angles()[i];
    DRIFTWISE_CO_TRY(const auto reply, co_await ask(std::to_string(angle.device_axis) + "TP"));
    const auto value = parse_value(reply, angle.device_axis);
    if (!value) co_return wrong(value);
    out.values.push_back(
        {angle.channel.name(), angle.sign * arcsec_from(*value, set_ups_[i].unit)});
  }
  out.end = clock_.now().utc;
  for (std::size_t i = 0; i < device_.angles().size(); ++i)
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_still_set_up(i));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_spot());
  out.sequence = ++sequence_;
  co_return out;
}

Awaitable<Result<void>> Autocollimator::zero() {
  co_return transport::no_zero(device_, "an autocollimator's angle is absolute");
}

}  // namespace driftwise::lds1000
