#include "drivers/pi_gcs/gcs_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/pi_gcs/gcs_codec.h"
#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"

namespace driftwise::gcs {
namespace {

constexpr int kMaxErrorReads = 12;
constexpr int kAnswersAtRest = 2;  // as MotionController::stop promises

std::vector<std::string> axis_names(const DeviceDescription& device) {
  std::vector<std::string> out;
  for (const auto& axis : device.axes()) out.push_back(axis.device_axis);
  return out;
}

}  // namespace

GcsController::GcsController(DeviceDescription device, Options options,
                             const transport::Address& address, asio::any_io_executor executor,
                             Clock& clock, std::shared_ptr<locks::Claims> claims)
    : LineDevice(
          std::move(device), address, executor, clock,
          {.resync_request = "*IDN?\n", .framing = transport::gcs_reply, .serial = options.serial}),
      options_(std::move(options)),
      claims_(std::move(claims)),
      mutex_(executor),
      axes_(axis_names(device_)),
      trap_(nanoseconds_from_s(options_.start_delay_s)) {}

tl::unexpected<Error> GcsController::stopped() const {
  return fail(ErrorCode::aborted, reasons::kStopped,
              "device '" + device_.id + "' at " + device_.address + ": stopped");
}

Awaitable<Result<GcsController::Fetched>> GcsController::fetch(std::vector<std::string> queries) {
  Fetched replies;
  if (!options_.pipelining) co_return replies;
  holds_no_error_ = false;
  std::string message;
  for (const auto& query : queries) message += query;
  DRIFTWISE_CO_TRY(const auto joined, co_await link_.ask(std::move(message), timeout_,
                                                         static_cast<int>(queries.size())));
  for (std::string_view rest = joined; !rest.empty();) {
    const std::size_t length = std::min(transport::gcs_reply(rest), rest.size());
    replies.emplace_back(rest.substr(0, length));
    rest.remove_prefix(length);
  }
  co_return replies;
}

GcsController::Text GcsController::next(Fetched& fetched, std::string query) {
  if (fetched.empty()) co_return co_await ask(std::move(query));
  std::string reply = std::move(fetched.front());
  fetched.pop_front();
  co_return reply;
}

Awaitable<Result<int>> GcsController::take_error_number() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("ERR?\n"));
  co_return error_number(reply);
}

Result<int> GcsController::error_number(std::string_view reply) {
  auto number = checked(parse_error_number(reply));
  holds_no_error_ = number && *number == 0;
  return number;
}

void GcsController::note_old_error(int number, const std::string& found) {
  if (number == 0) return;
  old_error_ = "error " + describe_error(number) + ", found " + found;
}

Awaitable<Result<void>> GcsController::command(std::string text) {
  const auto name = text.substr(0, text.find('\n'));
  std::string reply;
  if (holds_no_error_) {
    DRIFTWISE_CO_TRY(reply, co_await ask(text + "ERR?\n"));
  } else {
    std::vector<std::string> queries{"ERR?\n", text + "ERR?\n"};
    DRIFTWISE_CO_TRY(auto fetched, co_await fetch(std::move(queries)));
    DRIFTWISE_CO_TRY(const auto before, co_await next(fetched, "ERR?\n"));
    DRIFTWISE_CO_TRY(const auto old, error_number(before));
    note_old_error(old, "before " + name + " was sent");
    DRIFTWISE_CO_TRY(reply, co_await next(fetched, text + "ERR?\n"));
  }
  DRIFTWISE_CO_TRY(const auto number, error_number(reply));
  if (number == 0) co_return Result<void>{};
  if (number == kNoReferenceOrServo) co_return co_await refused_by_error_5(name);
  co_return link_.wrong_reply(refusal(number, name));
}

// One number for two states of the controller, and what a person does about them differs.
Awaitable<Result<void>> GcsController::refused_by_error_5(std::string text) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await refresh_servo());
  if (options_.referenced_by == "memory")
    referenced_ = referenced_ && !servo_on_;
  else
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await refresh_referenced());
  auto error = refusal(kNoReferenceOrServo, text);
  // Without a reference the axes are homed in any case, which is what switches the servo on.
  if (!referenced_) co_return link_.wrong_reply(error);
  if (!servo_on_) {
    error.reason = reasons::kServoOff;
    error.message = "controller refused " + text +
                    " with error 5, and SVO? says that the servo is "
                    "off: look who switched it off and why; homing by a person switches it on, or "
                    "switch it on at the controller";
  } else {
    error.reason = reasons::kRefused;
    error.message = "controller refused " + text +
                    " with error 5 (not referenced or servo off), "
                    "but says itself that the axes are referenced and the servo is on: look at the "
                    "controller";
  }
  co_return link_.wrong_reply(error);
}

Awaitable<Result<void>> GcsController::refresh_servo() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("SVO?\n"));
  DRIFTWISE_CO_TRY(const auto servos, checked(parse_axis_flags(reply, axes_)));
  servo_on_ = std::all_of(servos.begin(), servos.end(), [](bool is_on) { return is_on; });
  co_return Result<void>{};
}

// PROTOCOLS.md section 8: ERR? first, then the mask and ONT?. A controller that halts an axis at a
// limit switch may say "on target": of where it halted.
Awaitable<Result<void>> GcsController::look_at_end_of_motion() {
  has_ended_ = true;
  std::vector<std::string> queries{"ERR?\n", "SVO?\n"};
  DRIFTWISE_CO_TRY(auto fetched, co_await fetch(std::move(queries)));
  DRIFTWISE_CO_TRY(const auto error_text, co_await next(fetched, "ERR?\n"));
  DRIFTWISE_CO_TRY(const auto number, error_number(error_text));
  note_old_error(number, "at the end of a motion");
  if (number != 0) halted_because_ = "error " + describe_error(number);
  DRIFTWISE_CO_TRY(const auto servo_text, co_await next(fetched, "SVO?\n"));
  DRIFTWISE_CO_TRY(const auto servos, checked(parse_axis_flags(servo_text, axes_)));
  servo_on_ = std::all_of(servos.begin(), servos.end(), [](bool is_on) { return is_on; });
  co_return Result<void>{};
}

Awaitable<Result<void>> GcsController::refresh_referenced() {
  if (options_.referenced_by == "memory") co_return Result<void>{};
  if (options_.referenced_by == "status") {
    DRIFTWISE_CO_TRY(const auto reply, co_await ask(std::string(1, kStatusByte)));
    DRIFTWISE_CO_TRY(const auto word, checked(parse_hex(reply)));
    referenced_ = (word & kStatusReferenced) != 0;
    co_return Result<void>{};
  }
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("FRF?\n"));
  DRIFTWISE_CO_TRY(const auto flags, checked(parse_axis_flags(reply, axes_)));
  referenced_ = std::all_of(flags.begin(), flags.end(), [](bool flag) { return flag; });
  co_return Result<void>{};
}

Awaitable<Result<MotionState>> GcsController::read_state() {
  const CellTime asked = clock_.now().utc;
  // The position comes last: read before "on target" it would still be the position of a moving
  // axis.
  const std::string moving_query(1, kMovingByte);
  std::vector<std::string> queries{moving_query, "ONT?\n", "POS?\n"};
  DRIFTWISE_CO_TRY(auto fetched, co_await fetch(std::move(queries)));
  DRIFTWISE_CO_TRY(const auto mask_text, co_await next(fetched, moving_query));
  DRIFTWISE_CO_TRY(const auto mask, checked(parse_hex(mask_text)));
  DRIFTWISE_CO_TRY(const auto on_target_text, co_await next(fetched, "ONT?\n"));
  DRIFTWISE_CO_TRY(const auto on_target, checked(parse_axis_flags(on_target_text, axes_)));
  DRIFTWISE_CO_TRY(const auto position_text, co_await next(fetched, "POS?\n"));
  DRIFTWISE_CO_TRY(auto positions, checked(parse_axis_values(position_text, axes_)));
  MotionState state;
  state.at = clock_.now().utc;
  state.q_mm = std::move(positions);
  state.moving = trap_.under_way(mask != 0, asked);
  state.referenced = referenced_;
  state.on_target = !state.moving &&
                    std::all_of(on_target.begin(), on_target.end(), [](bool flag) { return flag; });
  answers_at_rest_ = state.moving ? 0 : answers_at_rest_ + 1;
  if (answers_at_rest_ >= kAnswersAtRest) stop_owed_ = false;
  if (!state.moving && (!has_ended_ || !state.on_target || !servo_on_))
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await look_at_end_of_motion());
  state.on_target = state.on_target && servo_on_;
  state.servo_on = servo_on_;
  state.halted_because = halted_because_;
  state.old_error = std::exchange(old_error_, {});
  co_return state;
}

Awaitable<Result<MotionState>> GcsController::look(std::int64_t stops_seen, bool also_referenced) {
  const auto lock = co_await mutex_.lock();
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready(stops_seen));
  if (also_referenced) {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await refresh_referenced());
  }
  co_return co_await read_state();
}

Awaitable<Result<MotionState>> GcsController::state() { return look(stops_, false); }

Result<void> GcsController::check_soft_limits(std::span<const double> q_mm) const {
  if (q_mm.size() != axes_.size()) {
    return fail(ErrorCode::invalid_argument, reasons::kWrongCount,
                "device '" + device_.id + "': a move of " + std::to_string(q_mm.size()) +
                    " axes, expected " + std::to_string(axes_.size()));
  }
  for (std::size_t i = 0; i < q_mm.size(); ++i) {
    const auto& axis = device_.axes()[i];
    if (q_mm[i] >= axis.min_mm && q_mm[i] <= axis.max_mm) continue;  // false for NaN too
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.9g mm asked of %s, soft limits are %.9g .. %.9g mm; nothing was sent", q_mm[i],
                  axis.channel.name().c_str(), axis.min_mm, axis.max_mm);
    return fail(ErrorCode::out_of_range, reasons::kSoftLimit,
                "device '" + device_.id + "': " + text);
  }
  return {};
}

Awaitable<Result<void>> GcsController::start_move(std::span<const double> q_mm) {
  if (auto inside = check_soft_limits(q_mm); !inside) co_return inside;
  const std::string text =
      encode_move(axes_, q_mm);  // now: the span may not outlive the first wait
  const std::int64_t stops_seen = stops_;
  const auto lock = co_await mutex_.lock();
  if (auto ready = co_await get_ready(stops_seen); !ready) co_return ready;
  // Armed before it is sent: a move whose answer got lost may have started all the same.
  trap_.commanded(clock_.now().utc);
  halted_because_.clear();
  has_ended_ = false;
  auto accepted = co_await command(text);
  if (accepted) trap_.commanded(clock_.now().utc);
  co_return accepted;
}

Awaitable<Result<void>> GcsController::start_referencing(std::int64_t stops_seen) {
  const auto lock = co_await mutex_.lock();
  if (auto ready = co_await get_ready(stops_seen); !ready) co_return ready;
  referenced_ = false;
  halted_because_.clear();
  has_ended_ = false;
  if (auto on = co_await command(encode_switch("SVO", axes_, 1)); !on) co_return on;
  servo_on_ = true;
  trap_.commanded(clock_.now().utc);
  auto accepted = co_await command(encode_command(options_.reference, axes_));
  if (accepted) trap_.commanded(clock_.now().utc);
  co_return accepted;
}

Awaitable<Result<void>> GcsController::home() {
  // From the place of the last progress, so that noise cannot add up to a way: above the noise of
  // any scale that a cell may have (RunRules::quiet_nm), far below the way of a referencing axis.
  // Not the range seen so far: a referencing axis turns round and goes where it has been.
  constexpr double kProgress_mm = 1e-3;
  const std::int64_t stops_seen = stops_;
  if (auto started = co_await start_referencing(stops_seen); !started) co_return started;
  CellTime last_progress = clock_.now().utc;
  std::vector<double> last_mm(axes_.size(), 1e300);
  for (;;) {
    co_await clock_.sleep_for(nanoseconds_from_s(options_.home_poll_s));
    DRIFTWISE_CO_TRY(const auto now, co_await look(stops_seen, true));
    const bool done = options_.referenced_by == "memory" ? now.on_target : now.referenced;
    if (!now.moving && done && now.servo_on) break;
    if (!now.moving && (!now.servo_on || !now.halted_because.empty()))
      co_return link_.refused(
          now.servo_on ? reasons::kRefused : reasons::kServoOff,
          options_.reference + " was accepted and the controller ended it: " +
              (now.servo_on ? std::string() : "the servo is off, ") +
              (now.halted_because.empty() ? "no error number" : now.halted_because) +
              "; look at the axes, the limit switches and the emergency stop");
    for (std::size_t i = 0; i < last_mm.size(); ++i) {
      if (std::abs(now.q_mm[i] - last_mm[i]) <= kProgress_mm) continue;
      last_mm[i] = now.q_mm[i];
      last_progress = now.at;
    }
    if (now.at - last_progress > nanoseconds_from_s(options_.home_stall_s)) {
      co_return fail(
          ErrorCode::deadline_exceeded, reasons::kHomingStalled,
          "device '" + device_.id + "' at " + device_.address + ": " + options_.reference +
              " accepted, but no axis has moved by more than 1 um for " +
              digits_text(options_.home_stall_s) +
              " s and the axes are not referenced; look at the reference switch and the servo");
    }
  }
  referenced_ = true;
  co_return Result<void>{};
}

Awaitable<Result<void>> GcsController::stop() {
  ++stops_;
  stop_owed_ = true;
  answers_at_rest_ = 0;
  holds_no_error_ = false;
  const std::string_view stop_byte(&kStopByte, 1);
  // A second stop halts again but leaves the first one's tidying alone: cut in the middle of it,
  // two equal answers would be under way and the line out of step.
  if (stopping_ == 0)
    link_.interrupt(stop_byte, reasons::kStopped);
  else
    link_.write_now(stop_byte);
  ++stopping_;
  const std::int64_t own_stop = stops_;
  const auto lock = co_await mutex_.lock();
  // One tidying is under way at most, and the next one is that of every stop that came meanwhile:
  // they queue for the line, and one is worth as much as many.
  if (tidied_stops_ < own_stop) {
    const std::int64_t all_stops = stops_;
    tidied_ = co_await tidy_after_stop();
    tidied_stops_ = all_stops;
  }
  --stopping_;
  co_return tidied_;
}

Awaitable<Result<void>> GcsController::tidy_after_stop() {
  if (auto up = co_await link_.connect(timeout_); !up) co_return up;
  // A new connection: the stop byte goes out first, and the error number is read.
  if (!is_set_up()) co_return co_await set_up_or_drop();
  // 0x18 leaves error 10 behind; ours is the only command that may still have failed before it.
  for (int i = 0; i < kMaxErrorReads; ++i) {
    DRIFTWISE_CO_TRY(const auto number, co_await take_error_number());
    if (number == 0) break;
    if (number == kStoppedError)
      trap_.disarm();  // a move not yet begun is cancelled as well
    else {
      note_old_error(number, "after a stop");
      halted_because_ = "error " + describe_error(number);
    }
  }
  co_return Result<void>{};
}

void GcsController::close() {
  ++stops_;
  link_.close();
}

}  // namespace driftwise::gcs
