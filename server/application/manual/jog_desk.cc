#include "server/application/manual/jog_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cmath>

#include "server/application/motion/keep_out.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/stop_desk.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

// Of wall time: between two looks at the controller.
constexpr std::chrono::milliseconds kBetweenLooks{10};
constexpr std::chrono::seconds kStopWithin{1};
// Of cell time: for which a controller may say "on target" away from the end of a step.
constexpr double kHeldUp_s = 2;

}  // namespace

struct JogDesk::Jog {
  Jog(const asio::any_io_executor& executor, RunControl& moving, TaskGroup::Membership membership)
      : control(moving), task(std::move(membership)), changed(executor) {}
  std::int64_t id = 0;
  Caller caller;
  std::string lease_token;
  JogOrder order;
  std::size_t axis = 0;
  std::vector<double> target_mm;
  AxesToMove moved;     // the axis; others of its controller are told where they are
  RunControl& control;  // valid until over
  std::optional<TaskGroup::Membership> task;
  Signal changed;
  std::chrono::nanoseconds last_sign{0};
  bool halting = false;
  JogState state;
  std::optional<Error> error;  // that ended it
};

JogDesk::JogDesk(asio::any_io_executor executor, Workbench& bench, RunEngine& engine,
                 RightToMove& right, const LeaseBook& leases, TaskGroup& tasks, bool by_wall)
    : executor_(std::move(executor)),
      bench_(bench),
      engine_(engine),
      right_(right),
      leases_(leases),
      tasks_(tasks),
      by_wall_(by_wall) {}

std::chrono::nanoseconds JogDesk::wall_now() const {
  if (by_wall_) return std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::nanoseconds(bench_.clock.now().monotonic_ns);
}

Awaitable<void> JogDesk::wall_sleep(std::chrono::nanoseconds duration) {
  if (!by_wall_) {
    co_await bench_.clock.sleep_for(duration);
    co_return;
  }
  asio::steady_timer timer(executor_, std::chrono::ceil<asio::steady_timer::duration>(duration));
  co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
}

Result<std::size_t> JogDesk::axis_of(const JogOrder& order) const {
  const auto motors = bench_.description.motor_channels();
  const auto found = std::ranges::find(motors, order.channel, &Channel::name);
  if (found == motors.end()) {
    std::string known;
    for (const auto& motor : motors) known += (known.empty() ? "" : ", ") + motor.name();
    return fail(ErrorCode::invalid_argument, reasons::kUnknownAxis,
                fmt::format("found axis '{}', expected one of {}", order.channel, known));
  }
  if (!(std::abs(order.step_mm) > 0 && std::abs(order.step_mm) <= kMostStep_mm))
    return fail(ErrorCode::invalid_argument, reasons::kBadStep,
                fmt::format("found a step of {} mm, expected one other than 0 and of at most {:g} "
                            "mm: 'move' goes farther",
                            order.step_mm, kMostStep_mm));
  return static_cast<std::size_t>(found - motors.begin());
}

// The controller takes all its axes in one command. Another axis that rests at its limit may be
// read back a few nanometres outside and is sent to the limit; a longer way is a motion of its own,
// which nobody asked for.
Result<void> JogDesk::hold_others(std::size_t axis, std::vector<double>& q_mm) const {
  const auto& cell = bench_.description;
  std::size_t first = 0;
  for (const auto& device : cell.devices) {
    const auto& axes = device.axes();
    const bool is_told = axis >= first && axis < first + axes.size();
    for (std::size_t i = 0; is_told && i < axes.size() && first + i < q_mm.size(); ++i) {
      double& at_mm = q_mm[first + i];
      const double inside_mm = std::clamp(at_mm, axes[i].min_mm, axes[i].max_mm);
      if (first + i == axis) continue;
      if (!(nm_from_mm(std::abs(at_mm - inside_mm)) <= cell.run.in_position_nm))
        return fail(ErrorCode::out_of_range, reasons::kSoftLimit,
                    fmt::format("{} is at {:.6f} mm, the soft limits of axis {} are {:g} to {:g} "
                                "mm: controller '{}' would drive it there with the step: home, or "
                                "move it inside first",
                                axes[i].channel.name(), at_mm, axes[i].device_axis, axes[i].min_mm,
                                axes[i].max_mm, device.id));
      at_mm = inside_mm;
    }
    first += axes.size();
  }
  return {};
}

Result<void> JogDesk::check_step(const std::vector<double>& from_mm,
                                 const std::vector<double>& to_mm, const AxesToMove& moved) const {
  DRIFTWISE_RETURN_IF_ERROR(check_soft_limits(bench_.description, to_mm, moved));
  return check_keep_out(bench_.description, from_mm, to_mm);
}

Awaitable<Result<JogState>> JogDesk::begin(Caller caller, std::string lease_token, JogOrder order,
                                           HoldAnswer answer) {
  auto lock = std::optional(co_await right_.turn());
  DRIFTWISE_CO_TRY(const auto axis, axis_of(order));
  DRIFTWISE_CO_RETURN_IF_ERROR(right_.check_by_hand(caller, lease_token, answer));
  // From here on a stop reaches it, also while the controller is asked where the axes are.
  auto jog = std::make_shared<Jog>(executor_, right_.begin_by_hand(), tasks_.join());
  lock.reset();
  jog->caller = caller;
  jog->lease_token = lease_token;
  jog->order = order;
  jog->axis = axis;
  jog->id = jog->state.id = ++last_id_;
  jog->last_sign = wall_now();
  const auto give_up = [&](Error error) -> Result<JogState> {
    jog->state.over = true;
    jog->state.end_reason = error.message;
    right_.end_by_hand();
    return tl::unexpected(std::move(error));
  };
  jog->moved = no_axes(bench_.description);
  jog->moved.named[axis] = true;
  const auto from = co_await state_before(bench_, jog->moved);
  if (!from) co_return give_up(from.error());
  jog->target_mm = jog->state.q_mm = from->q_mm;
  if (auto held = hold_others(axis, jog->target_mm); !held) co_return give_up(held.error());
  auto first = jog->target_mm;
  if (axis < first.size()) first[axis] += order.step_mm;
  if (auto inside = check_step(from->q_mm, first, jog->moved); !inside)
    co_return give_up(inside.error());
  if (auto wanted = jog->control.check(); !wanted) co_return give_up(wanted.error());
  // On record before it moves. The next sign of the client is due from the first step on.
  auto recording = bench_.events.record_first(
      caller, "axes.jog",
      order.held ? fmt::format("{} holds {} in steps of {:+g} mm, from {:.6f} mm", caller.name,
                               order.channel, order.step_mm, jog->target_mm[axis])
                 : fmt::format("{} moves {} by {:+g} mm, from {:.6f} mm", caller.name,
                               order.channel, order.step_mm, jog->target_mm[axis]));
  if (auto recorded = co_await std::move(recording); !recorded) co_return give_up(recorded.error());
  if (auto wanted = jog->control.check(); !wanted) co_return give_up(wanted.error());
  jog->last_sign = wall_now();
  engine_.remeasure_zero("jogged by hand");
  jog_ = jog;
  if (order.held) {
    tasks_.spawn(carry(jog));
    tasks_.spawn(listen(jog));
    co_return jog->state;
  }
  co_await carry(jog);
  if (jog->error) co_return tl::unexpected(*jog->error);
  co_return jog->state;
}

Awaitable<void> JogDesk::carry(JogPtr jog) {
  const auto done = co_await step_on(*jog);
  while (jog->halting) co_await jog->changed.wait();
  if (!done) jog->error = done.error();
  if (!done && jog->state.end_reason.empty()) {
    jog->state.end_reason = done.error().message;
    // The end of a jog may leave the axis in motion. A stop that a person pressed has its own desk.
    if (jog->state.steps > 0 && !bench_.stops.pending()) {
      auto stopping = stop_axes(*jog);
      co_await std::move(stopping);
    }
  }
  jog->state.over = true;
  right_.end_by_hand();
  jog->task.reset();
  jog->changed.raise();
}

Awaitable<Result<void>> JogDesk::step_on(Jog& jog) {
  do {
    const auto from_mm = jog.target_mm;
    auto next = from_mm;
    next[jog.axis] += jog.order.step_mm;
    if (const auto inside = check_step(from_mm, next, jog.moved); !inside) {
      jog.state.released = true;
      jog.state.end_reason = inside.error().message;
      co_return Result<void>{};
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(jog.control.check());
    bench_.writer.add(MoveRecord{std::nullopt, bench_.clock.now(), from_mm, next,
                                 "jog by hand: " + jog.caller.name});
    jog.target_mm = next;
    ++jog.state.steps;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await bench_.devices.start_move(next, jog.moved));
    auto arriving = arrive(jog, from_mm[jog.axis]);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(arriving));
  } while (jog.order.held);
  jog.state.released = true;
  jog.state.end_reason = "the step was made";
  co_return Result<void>{};
}

// A controller that halted an axis at an obstacle or a limit switch may say "on target" of where it
// halted: the readback says whether the step was made, and the next one counts from there.
Awaitable<Result<void>> JogDesk::arrive(Jog& jog, double from_mm) {
  const auto& rules = bench_.description.run;
  auto held_up = rules;
  held_up.move_timeout_s = std::min(kHeldUp_s, rules.move_timeout_s);
  MoveLimit limit(rules, bench_.clock.now().utc);
  std::optional<MoveLimit> standing;  // since it says that the step is over
  while (true) {
    DRIFTWISE_CO_TRY(const auto state, co_await state_of(bench_.devices, jog.moved));
    jog.state.q_mm = state.q_mm;
    DRIFTWISE_CO_RETURN_IF_ERROR(jog.control.check());
    const auto now = bench_.clock.now().utc;
    const double at_mm = state.q_mm.at(jog.axis);
    double& target_mm = jog.target_mm[jog.axis];
    const double off_nm = nm_from_mm(std::abs(at_mm - target_mm));
    const bool is_over = !state.moving && state.on_target;
    if (is_over && off_nm <= rules.in_position_nm) {
      target_mm = at_mm;
      co_return Result<void>{};
    }
    if (!is_over)
      standing.reset();
    else if (!standing)
      standing.emplace(held_up, now);
    const bool is_held_up = standing && standing->has_passed(off_nm, now);
    if (limit.has_passed(off_nm, now) || is_held_up)
      co_return fail(
          ErrorCode::deadline_exceeded, reasons::kNotSettled,
          fmt::format("{} is at {:.6f} mm, {:+.6f} mm from where a step of {:+g} mm began, and {}: "
                      "the step was not made, and the axis was halted; look what is in its way",
                      jog.order.channel, at_mm, at_mm - from_mm, jog.order.step_mm,
                      is_held_up ? "the controller says that it is on target there"
                                 : fmt::format("no nearer for {:g} s (move_timeout_s)",
                                               rules.move_timeout_s)));
    co_await wall_sleep(kBetweenLooks);
    DRIFTWISE_CO_RETURN_IF_ERROR(jog.control.check());
  }
}

Awaitable<void> JogDesk::listen(JogPtr jog) {
  while (!jog->state.over && !jog->halting) {
    const auto silent = wall_now() - jog->last_sign;
    if (silent < kSilence) {
      co_await wall_sleep(kSilence - silent);
      continue;
    }
    const auto why = fmt::format("no sign of the client of {} for {} ms: {} was stopped",
                                 jog->caller.name, kSilence.count(), jog->order.channel);
    bench_.events.record_own("axes.jog_lost", why);
    auto halting = halt(jog, why, false);
    co_await std::move(halting);
    co_return;
  }
}

Awaitable<void> JogDesk::halt(JogPtr jog, std::string why, bool released) {
  if (jog->state.over || jog->halting) co_return;
  jog->halting = true;
  jog->state.end_reason = why;
  jog->state.released = released;
  jog->control.abort(why);
  auto stopping = stop_axes(*jog);
  co_await std::move(stopping);
  jog->changed.raise();
}

Awaitable<void> JogDesk::stop_axes(Jog& jog) {
  jog.halting = true;
  const auto sent = co_await bench_.devices.stop();
  bool rests = false;
  if (sent) rests = co_await at_rest();
  // A controller that does not say so is told for as long as it takes, also by the next daemon.
  if (!rests) {
    auto pressing = bench_.stops.press(jog.caller, jog.state.end_reason);
    static_cast<void>(co_await std::move(pressing));
  }
  jog.halting = false;
}

Awaitable<bool> JogDesk::at_rest() {
  const auto limit = wall_now() + kStopWithin;
  for (int answers = 0; wall_now() < limit;) {
    const auto state = co_await bench_.devices.motion_state();
    if (!state) co_return false;
    answers = state->moving ? 0 : answers + 1;
    if (jog_) jog_->state.q_mm = state->q_mm;
    if (answers == StopDesk::kAnswers) co_return true;
    co_await wall_sleep(kBetweenLooks);
  }
  co_return false;
}

Result<JogDesk::JogPtr> JogDesk::find(std::int64_t id, const std::string& lease_token) const {
  if (!jog_ || jog_->id != id || jog_->lease_token != lease_token)
    return fail(ErrorCode::not_found, reasons::kNoSuchJog,
                fmt::format("there is no held movement {} of this lease: begin another", id));
  return jog_;
}

Result<JogState> JogDesk::hold(std::int64_t id, const std::string& lease_token) {
  DRIFTWISE_TRY(const auto jog, find(id, lease_token));
  if (!jog->state.over) {
    // The lease is the client's to renew; without it nobody may hold an axis.
    if (const auto ok = leases_.check(lease_token, bench_.clock.now().utc); ok)
      jog->last_sign = wall_now();
  }
  return jog->state;
}

Awaitable<Result<JogState>> JogDesk::end(std::int64_t id, std::string lease_token) {
  DRIFTWISE_CO_TRY(const auto jog, find(id, lease_token));
  auto halting = halt(jog, "let go", true);
  co_await std::move(halting);
  while (!jog->state.over) co_await jog->changed.wait();
  co_return jog->state;
}

}  // namespace driftwise::application
