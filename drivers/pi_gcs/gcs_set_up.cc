// How a controller is found and made ready after every new connection, and how one that did not
// answer in time shows whether it has been switched off and on meanwhile. Nothing here gives a
// drive its current.

#include <algorithm>
#include <cstdio>

#include "drivers/pi_gcs/gcs_codec.h"
#include "drivers/pi_gcs/gcs_controller.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::gcs {

Awaitable<Result<void>> GcsController::prepare() {
  const std::int64_t stops_seen = stops_;
  const auto lock = co_await mutex_.lock();
  co_return co_await get_ready(stops_seen);
}

Awaitable<Result<void>> GcsController::get_ready(std::int64_t stops_seen) {
  if (stops_seen != stops_) co_return stopped();
  if (auto up = co_await link_.connect(timeout_); !up) co_return up;
  if (!is_set_up())
    if (auto done = co_await set_up_or_drop(); !done) co_return done;
  if (stops_seen != stops_) co_return stopped();  // while it was being set up
  co_return Result<void>{};
}

Result<void> GcsController::claim(const std::string& key) {
  if (!claims_ || key.empty()) return {};
  return claims_->take(device_.id, key);
}

Awaitable<Result<void>> GcsController::set_up() {
  if (auto ours = claim(link_.peer_key()); !ours) co_return ours;
  // After a stop the line is out of step and the identity not known yet: start over rather than
  // guess.
  if (!link_.in_step()) {
    link_.drop("out of step before it was set up");
    if (auto up = co_await link_.connect(timeout_); !up) co_return up;
  }
  // On the same connection a move whose answer got lost may be under way.
  const bool is_known = !is_new_connection();
  if (!is_known) {
    referenced_ = false;
    if (!stop_owed_) trap_.disarm();
  }
  answers_at_rest_ = 0;
  if (stop_owed_)
    if (auto told = co_await link_.tell(std::string(1, kStopByte), timeout_); !told) co_return told;
  DRIFTWISE_CO_TRY(const auto identity, co_await ask("*IDN?\n"));
  const std::string identity_text(transport::without_line_ends(identity));
  know_identity(identity_text, identity);
  if (auto ours = claim(serial_number_key(identity_text)); !ours) co_return ours;
  DRIFTWISE_CO_TRY(const auto old,
                   co_await take_error_number());  // of the stop, or of an earlier client
  if (old == kStoppedError)
    trap_.disarm();
  else
    note_old_error(old, "when it was set up");
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await refresh_servo());
  // Off in a controller that was switched on again: it then has lost the rest of its set-up too.
  if (is_known && servo_on_) co_return co_await refresh_referenced();
  if (is_known) referenced_ = false;

  DRIFTWISE_CO_TRY(const auto names_text, co_await ask("SAI?\n"));
  DRIFTWISE_CO_TRY(const auto names, checked(parse_axis_names(names_text)));
  for (const auto& axis : axes_) {
    if (std::find(names.begin(), names.end(), axis) == names.end())
      co_return link_.refused(reasons::kUnknownAxis, "the controller has no axis '" + axis +
                                                         "': correct device_axis in the cell file");
  }
  if (options_.travel_query) {
    if (auto inside = co_await check_travel(); !inside) co_return inside;
  }
  if (options_.velocity_mm_s > 0) {
    char value[40];
    std::snprintf(value, sizeof value, " %.9g", options_.velocity_mm_s);
    std::string text = options_.velocity_command;
    if (text == "VLS") {
      text += value;
    } else {
      for (const auto& axis : axes_) text += " " + axis + value;
    }
    if (auto set = co_await command(text + "\n"); !set) co_return set;
  }
  if (auto known = co_await refresh_referenced(); !known) co_return known;
  co_return Result<void>{};
}

// The soft limits are ours, the travel is the controller's: ours must lie inside.
Awaitable<Result<void>> GcsController::check_travel() {
  std::vector<std::string> queries{"TMN?\n", "TMX?\n"};
  auto fetched = co_await fetch(std::move(queries));
  Result<std::string> low_text, high_text;
  if (fetched) low_text = co_await next(*fetched, "TMN?\n");
  if (!fetched || !low_text) {
    Error error = fetched ? low_text.error() : fetched.error();
    if (error.code == ErrorCode::deadline_exceeded)
      error.message += "; if it knows no TMN?, set travel_query = \"off\"";
    co_return tl::unexpected(error);
  }
  DRIFTWISE_CO_TRY(const auto low, checked(parse_axis_values(*low_text, axes_)));
  high_text = co_await next(*fetched, "TMX?\n");
  DRIFTWISE_CO_RETURN_IF_ERROR(high_text);
  DRIFTWISE_CO_TRY(const auto high, checked(parse_axis_values(*high_text, axes_)));
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto& axis = device_.axes()[i];
    if (axis.min_mm >= low[i] && axis.max_mm <= high[i]) continue;
    char text[200];
    std::snprintf(
        text, sizeof text,
        "soft limits of %s are %.9g .. %.9g mm, the controller travels %.9g .. %.9g mm only",
        axis.channel.name().c_str(), axis.min_mm, axis.max_mm, low[i], high[i]);
    co_return link_.refused(reasons::kLimitsBeyondTravel, text);
  }
  co_return Result<void>{};
}

}  // namespace driftwise::gcs
