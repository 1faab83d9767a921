#include "server/application/motion/start_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/datum_opening.h"
#include "server/application/motion/joining.h"
#include "server/application/motion/keep_out.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/zero_shift.h"
#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

// What keeps a stabiliser from being ready; empty: nothing.
std::string stabiliser_trouble(const RunScope& scope, std::size_t device) {
  const auto& description = scope.bench.devices.description(device);
  const std::string stem = symbol_from_id(description.id);
  const auto& history = scope.bench.recorder.history();
  const auto* present = history.latest(stem + "_degC");
  const auto* wanted = history.latest(stem + "_set_degC");
  if (!present || !wanted || is_missing(present->value) || is_missing(wanted->value))
    return fmt::format("the stabiliser {} at {} gave no temperature yet", description.id,
                       description.address);
  const double age_s = seconds_from(scope.bench.clock.now().utc - present->at);
  if (age_s > description.max_age_s)
    return fmt::format("the stabiliser {} at {} is silent: its last temperature is {:.0f} s old",
                       description.id, description.address, age_s);
  const double off_k = present->value - wanted->value;
  const double band_k = scope.bench.description.checks.stabiliser_band_k;
  if (std::abs(off_k) <= band_k) return {};
  return fmt::format(
      "the stabiliser {} is at {:.3f} degC, {:+.3f} K from its set-point, limit {:g} K",
      description.id, present->value, off_k, band_k);
}

// What each length shows while the axes hold still, nm; with one axis and one length the scale's
// own wander is taken out.
Awaitable<Result<std::vector<double>>> zeros_now_nm(RunScope& scope) {
  const auto& description = scope.bench.description;
  DRIFTWISE_CO_TRY(auto state, co_await scope.bench.devices.motion_state());
  std::vector<double> zeros;
  for (const auto device : scope.bench.devices.with_role(DeviceRole::length)) {
    DRIFTWISE_CO_TRY(auto reading, co_await scope.bench.devices.read(device));
    scope.bench.recorder.observe(reading);
    if (!reading.rejected.empty())
      co_return fail(ErrorCode::failed_precondition, reasons::kImplausible,
                     reading.rejected.front().reason);
    const auto* length = scope.bench.devices.description(device).length();
    const double* x_mm = length ? reading.find(length->channel.name()) : nullptr;
    if (!x_mm)
      co_return fail(ErrorCode::data_loss, reasons::kNoLength,
                     fmt::format("{} gave no length", reading.device));
    zeros.push_back(nm_from_mm(*x_mm));
  }
  if (zeros.size() == 1 && description.motor_channels().size() == 1 && !state.q_mm.empty())
    zeros.front() -= nm_from_mm(state.q_mm.front());
  co_return zeros;
}

// Of the length that drifts fastest.
Awaitable<Result<double>> measure_drift(RunScope& scope) {
  constexpr int kSamples = 21;
  const double window_s = scope.bench.description.checks.drift_window_s;
  std::vector<double> times_s;
  std::vector<std::vector<double>> zeros_nm(
      scope.bench.devices.with_role(DeviceRole::length).size());
  const auto begin = scope.bench.clock.now().utc;
  for (int k = 0; k < kSamples; ++k) {
    const auto due = begin + nanoseconds_from_s(window_s * k / (kSamples - 1));
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.sleep_until(due));
    DRIFTWISE_CO_TRY(const auto zeros, co_await zeros_now_nm(scope));
    times_s.push_back(seconds_from(scope.bench.clock.now().utc - begin));
    for (std::size_t i = 0; i < zeros.size(); ++i) zeros_nm[i].push_back(zeros[i]);
  }
  std::vector<double> drifts;
  for (const auto& zeros : zeros_nm) drifts.push_back(drift_nm_per_min(times_s, zeros));
  co_return largest_nm(drifts);
}

}  // namespace

Awaitable<Result<void>> check_thermometers(RunScope& scope) {
  scope.phase("waiting for the thermometers");
  double longest_period_s = 1;
  for (const auto device : scope.bench.devices.with_role(DeviceRole::temperature))
    longest_period_s = std::max(longest_period_s, scope.bench.devices.description(device).period_s);
  const auto limit = scope.bench.clock.now().utc +
                     nanoseconds_from_s(3 * longest_period_s + scope.rules.max_temperature_age_s);
  while (true) {
    const auto now = scope.bench.clock.now().utc;
    const auto joined = join_slow_channels(scope.bench.description, scope.bench.recorder.history(),
                                           now, scope.rules.max_temperature_age_s);
    if (joined) co_return Result<void>{};
    if (now > limit) co_return tl::unexpected(joined.error());
    if (auto ok = scope.control.check(); !ok) co_return ok;
    co_await scope.bench.recorder.next_reading_until(limit + std::chrono::milliseconds(1));
  }
}

Awaitable<Result<void>> check_stabilisers(RunScope& scope) {
  const auto begin = scope.bench.clock.now().utc;
  const double wait_s = scope.bench.description.checks.stabiliser_wait_s;
  bool waiting = false;
  for (const auto device : scope.bench.devices.with_role(DeviceRole::stabiliser)) {
    while (true) {
      const auto trouble = stabiliser_trouble(scope, device);
      if (trouble.empty()) break;
      const double waited_s = seconds_from(scope.bench.clock.now().utc - begin);
      if (waited_s > wait_s)
        co_return fail(ErrorCode::failed_precondition, reasons::kStabiliserOff,
                       fmt::format("{} after {:.0f} s: look at its power and its sensor, or raise "
                                   "[checks] stabiliser_wait_s",
                                   trouble, waited_s));
      if (!waiting) {
        waiting = true;
        if (auto ok = co_await scope.enter_waiting(trouble); !ok) co_return ok;
      }
      scope.phase("waiting for the stabiliser");
      if (auto ok = co_await scope.sleep_s(1.0); !ok) co_return ok;
    }
  }
  if (waiting) co_return co_await scope.leave_waiting();
  co_return Result<void>{};
}

Awaitable<Result<void>> check_drift(RunScope& scope) {
  if (!scope.bench.devices.has(DeviceRole::length) ||
      scope.bench.description.checks.drift_window_s <= 0)
    co_return Result<void>{};
  const auto begin = scope.bench.clock.now().utc;
  const double limit = scope.bench.description.checks.max_drift_nm_per_min;
  bool waiting = false;
  while (true) {
    scope.phase("measuring the drift at rest");
    DRIFTWISE_CO_TRY(const auto drift, co_await measure_drift(scope));
    if (std::abs(drift) <= limit) break;
    const auto trouble =
        fmt::format("the zero drifts by {:+.0f} nm/min at rest, limit {:g} nm/min", drift, limit);
    const double waited_s = seconds_from(scope.bench.clock.now().utc - begin);
    if (waited_s > scope.bench.description.checks.stabiliser_wait_s)
      co_return fail(
          ErrorCode::failed_precondition, reasons::kDriftTooFast,
          fmt::format(
              "{} after {:.0f} s: let the room settle, or raise [checks] max_drift_nm_per_min",
              trouble, waited_s));
    if (!waiting) {
      waiting = true;
      if (auto ok = co_await scope.enter_waiting(trouble); !ok) co_return ok;
    }
  }
  if (waiting) co_return co_await scope.leave_waiting();
  co_return Result<void>{};
}

Error servo_is_off() {
  return {
      ErrorCode::failed_precondition, reasons::kServoOff,
      "the servo of an axis is off, and nobody here switched it off: look who did and why; then "
      "home or resume the run, which switches it on, or switch it on at the controller"};
}

Awaitable<Result<void>> make_homed(RunScope& scope, bool in_any_case, SwitchOn switch_on) {
  auto clearing = clear_to_home(scope, in_any_case, switch_on);
  DRIFTWISE_CO_TRY(const bool is_wanted, co_await std::move(clearing));
  if (!is_wanted) co_return Result<void>{};
  co_return co_await send_home(scope);
}

Awaitable<Result<bool>> clear_to_home(RunScope& scope, bool in_any_case, SwitchOn switch_on) {
  DRIFTWISE_CO_TRY(auto state, co_await scope.bench.devices.motion_state());
  if (state.referenced && state.servo_on && !in_any_case) co_return false;
  const bool may_switch_on =
      switch_on == SwitchOn::yes || (switch_on == SwitchOn::if_unreferenced && !state.referenced);
  if (!state.servo_on && !may_switch_on) co_return tl::unexpected(servo_is_off());
  DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
  // Axes without a reference are nobody knows where. Others go to their zeros as in any move, in a
  // run one robot before the other where that keeps the distance.
  const auto& cell = scope.bench.description;
  if (state.referenced && !cell.keep_outs.empty()) {
    // One controller after the other: the last one is told long after the first.
    DRIFTWISE_CO_TRY(state, co_await state_before(scope, no_axes(cell)));
    if (const auto room = check_homing(cell, state.q_mm); !room) {
      if (!scope.run) co_return tl::unexpected(room.error());
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(
          scope, std::vector<double>(state.q_mm.size(), 0.0), "to the zeros before homing"));
    }
  }
  co_return true;
}

Awaitable<Result<void>> send_home(RunScope& scope) {
  scope.phase("homing");
  // The controller's own search ends from a side that nobody is told.
  scope.sides.assign(scope.bench.description.motor_channels().size(), '?');
  auto homed = co_await scope.bench.devices.home();
  if (homed) co_return homed;
  // The reference was sent: whatever ended the wait for it leaves axes that search on.
  auto halting = halted_by_hand(scope, homed.error());
  co_return tl::unexpected(co_await std::move(halting));
}

}  // namespace driftwise::application
