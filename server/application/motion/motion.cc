#include "server/application/motion/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "server/application/motion/keep_out.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

constexpr double kPoll_s = 0.1;

double largest_distance_nm(const std::vector<double>& a_mm, const std::vector<double>& b_mm,
                           const AxesToMove& moved) {
  double largest = a_mm.size() == b_mm.size() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a_mm.size(), b_mm.size()); ++i) {
    if (!moved.contains(i)) continue;
    const double distance = std::abs(nm_from_mm(a_mm[i] - b_mm[i]));
    // Also where it is no number.
    if (!(distance <= largest))
      largest = std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
  }
  return largest;
}

// The readbacks of the last settle_s.
class QuietWindow {
 public:
  QuietWindow(double settle_s, const AxesToMove& moved)
      : length_(nanoseconds_from_s(settle_s)), moved_(moved) {}
  void add(const MotionState& state) {
    seen_.push_back(state);
    // One sample at or before the window's begin is kept: it shows that the window is full.
    while (seen_.size() > 1 && state.at - seen_[1].at >= length_) seen_.pop_front();
  }
  bool full() const { return !seen_.empty() && seen_.back().at - seen_.front().at >= length_; }
  CellTime began() const { return seen_.front().at; }
  double peak_to_peak_nm() const {
    double widest = 0;
    for (std::size_t axis = 0; axis < seen_.front().q_mm.size(); ++axis) {
      if (!moved_.contains(axis)) continue;
      const auto [low, high] = std::minmax_element(
          seen_.begin(), seen_.end(),
          [axis](const auto& a, const auto& b) { return a.q_mm[axis] < b.q_mm[axis]; });
      widest = std::max(widest, nm_from_mm(high->q_mm[axis] - low->q_mm[axis]));
    }
    return widest;
  }

 private:
  Nanoseconds length_;
  const AxesToMove& moved_;
  std::deque<MotionState> seen_;
};

bool moves_any(const AxesToMove& moved, std::size_t first, std::size_t count) {
  for (std::size_t axis = first; axis < first + count; ++axis)
    if (moved.contains(axis)) return true;
  return false;
}

MotionState together(const std::vector<MotionState>& states, const AxesToMove& moved) {
  MotionState all{states.front().at, {}, false, true, true};
  for (const auto& one : states) {
    const bool counts = moves_any(moved, all.q_mm.size(), one.q_mm.size());
    all.at = std::max(all.at, one.at);
    all.q_mm.insert(all.q_mm.end(), one.q_mm.begin(), one.q_mm.end());
    if (!counts) continue;
    all.moving = all.moving || one.moving;
    all.referenced = all.referenced && one.referenced;
    all.on_target = all.on_target && one.on_target;
    all.servo_on = all.servo_on && one.servo_on;
    if (all.halted_because.empty()) all.halted_because = one.halted_because;
  }
  return all;
}

Awaitable<Result<void>> bring_to_rest(RunScope& scope) {
  constexpr double kRestWithin_s = 1, kBetweenLooks_s = 0.02;
  auto& bench = scope.bench;
  const auto in_time = [&bench] {
    return bench.clock.now().utc + nanoseconds_from_s(kRestWithin_s);
  };
  auto limit = in_time();
  // An exchange that another stop cut off says nothing of the axes: asked again.
  const auto is_cut = [&](const auto& answer) {
    return !answer && answer.error().code == ErrorCode::aborted && bench.clock.now().utc <= limit;
  };
  auto stopped = co_await bench.devices.stop();
  while (is_cut(stopped)) {
    co_await bench.clock.sleep_for(nanoseconds_from_s(kBetweenLooks_s));
    stopped = co_await bench.devices.stop();
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(stopped);
  limit = in_time();
  for (int answers = 0; answers < StopDesk::kAnswers;) {
    const auto state = co_await bench.devices.motion_state();
    if (is_cut(state)) {
      answers = 0;
      co_await bench.clock.sleep_for(nanoseconds_from_s(kBetweenLooks_s));
      continue;
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(state);
    answers = state->moving ? 0 : answers + 1;
    if (state->moving && bench.clock.now().utc > limit)
      co_return fail(ErrorCode::deadline_exceeded, reasons::kNotSettled,
                     fmt::format("the axes were halted and still move after {:g} s: use the "
                                 "emergency switch, and look at the controller",
                                 kRestWithin_s));
    co_await bench.clock.sleep_for(nanoseconds_from_s(kBetweenLooks_s));
  }
  co_return Result<void>{};
}

Awaitable<Result<Arrival>> wait_in_position(RunScope& scope, const std::vector<double>& q_mm,
                                            const AxesToMove& moved) {
  MoveLimit limit(scope.rules, scope.bench.clock.now().utc);
  while (true) {
    DRIFTWISE_CO_TRY(auto state, co_await state_of(scope.bench.devices, moved));
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
    const double off_nm = largest_distance_nm(state.q_mm, q_mm, moved);
    const auto now = scope.bench.clock.now();
    if (!state.moving && state.on_target && off_nm <= scope.rules.in_position_nm) {
      scope.bench.doubts.readback_is_good();
      co_return Arrival{Trouble::none, "", now, std::move(state.q_mm)};
    }
    const bool is_late = limit.has_passed(off_nm, now.utc);
    if (is_late && !state.moving && state.on_target) {
      // No servo that holds badly is so far away: then the run waits.
      constexpr double kFarAway = 10;
      const auto off = scope.bench.doubts.readback_is_off(
          fmt::format("the controller says that it is on target, its readback is {:.4g} nm from "
                      "the commanded position (limit {:g} nm): look at the scale and its reference",
                      off_nm, scope.rules.in_position_nm));
      if (off_nm > kFarAway * scope.rules.in_position_nm) co_return tl::unexpected(off.error());
    }
    if (is_late) {
      // An axis that something holds up may say that it does not move: its target stands, and it
      // would go there as soon as its way is free.
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await bring_to_rest(scope));
      co_return Arrival{Trouble::not_settled,
                        fmt::format("{:.0f} nm from the commanded position and no nearer for {:g} "
                                    "s (move_timeout_s), limit {:g} nm{}: halted",
                                    off_nm, scope.rules.move_timeout_s, scope.rules.in_position_nm,
                                    state.moving      ? ", still moving"
                                    : state.on_target ? ""
                                                      : ", not on target"),
                        now, std::move(state.q_mm)};
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.sleep_s(kPoll_s));
  }
}

Awaitable<Result<Arrival>> wait_quiet(RunScope& scope, Arrival arrival, const AxesToMove& moved) {
  if (scope.rules.settle_s <= 0) {
    scope.at_rest = arrival.in_position.utc;
    co_return arrival;
  }
  const auto limit =
      scope.bench.clock.now().utc +
      nanoseconds_from_s(std::max(scope.rules.move_timeout_s, 2 * scope.rules.settle_s));
  const double poll_s = std::max(0.05, scope.rules.settle_s / 8);
  QuietWindow window(scope.rules.settle_s, moved);
  while (true) {
    DRIFTWISE_CO_TRY(auto state, co_await scope.bench.devices.motion_state());
    window.add(state);
    if (window.full()) {
      const double peak_to_peak_nm = window.peak_to_peak_nm();
      if (peak_to_peak_nm <= scope.rules.quiet_nm) {
        scope.at_rest = window.began();
        co_return arrival;
      }
      if (scope.bench.clock.now().utc > limit) {
        arrival.trouble = Trouble::not_settled;
        arrival.sentence = fmt::format("quiet to {:.0f} nm peak to peak over {:g} s, limit {:g} nm",
                                       peak_to_peak_nm, scope.rules.settle_s, scope.rules.quiet_nm);
        co_return arrival;
      }
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.sleep_s(poll_s));
  }
}

}  // namespace

Awaitable<Result<MotionState>> state_of(DeviceBench& devices, AxesToMove moved) {
  DRIFTWISE_CO_TRY(const auto states, co_await devices.motion_states());
  co_return together(states, moved);
}

// The end of the daemon stops the axes itself, cuts off the exchanges of the movement by hand for
// it, and judges alone whether they rest.
Awaitable<Result<void>> halt_by_hand(RunScope& scope) {
  const auto is_others = [&scope] {
    return scope.run || scope.bench.stops.pending() || scope.control.shutting_down();
  };
  if (is_others()) co_return Result<void>{};
  const auto rests = co_await bring_to_rest(scope);
  if (rests || is_others()) co_return Result<void>{};
  if (rests.error().reason == reasons::kNotSettled) co_return rests;
  co_return fail(
      ErrorCode::deadline_exceeded, reasons::kNotSettled,
      "the axes could not be halted, use the emergency switch: " + rests.error().message);
}

Awaitable<Error> halted_by_hand(RunScope& scope, Error ended) {
  auto halting = halt_by_hand(scope);
  const auto rests = co_await std::move(halting);
  // What was cut off says "stopped", which says nothing of why.
  if (!scope.run && scope.control.shutting_down()) co_return scope.control.check().error();
  if (rests) co_return ended;
  ended.reason = reasons::kNotSettled;
  if (rests.error().message != ended.message) ended.message += "; " + rests.error().message;
  co_return ended;
}

AxesToMove no_axes(const CellDescription& cell) {
  return {std::vector<bool>(cell.motor_channels().size(), false)};
}

Awaitable<Result<MotionState>> state_before(Workbench& bench, AxesToMove moved) {
  DRIFTWISE_CO_TRY(const auto states, co_await bench.devices.motion_states());
  std::size_t first = 0;
  for (const auto& one : states) {
    if (one.moving && !moves_any(moved, first, one.q_mm.size()))
      co_return fail(ErrorCode::failed_precondition, reasons::kMoving,
                     fmt::format("{} is still moving, and nobody knows where it will be: wait "
                                 "until it is at rest, or stop it",
                                 bench.description.motor_channels().at(first).name()));
    first += one.q_mm.size();
  }
  co_return together(states, moved);
}

Awaitable<Result<MotionState>> state_before(RunScope& scope, AxesToMove moved) {
  auto before = co_await state_before(scope.bench, moved);
  if (before || before.error().reason != reasons::kMoving || !scope.run) co_return before;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await bring_to_rest(scope));
  co_return co_await state_before(scope.bench, moved);
}

Result<void> check_soft_limits(const CellDescription& description, const std::vector<double>& q_mm,
                               const AxesToMove& moved) {
  const auto axes = description.axes();
  if (q_mm.size() < axes.size())
    return fail(ErrorCode::invalid_argument, reasons::kAxisCount,
                fmt::format("{} motor coordinates were given, {} is missing", q_mm.size(),
                            axes[q_mm.size()].channel.name()));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto& axis = axes[i];
    if (!moved.contains(i) || (q_mm[i] >= axis.min_mm && q_mm[i] <= axis.max_mm)) continue;
    return fail(
        ErrorCode::out_of_range, reasons::kSoftLimit,
        fmt::format("{} = {} mm was asked for, the soft limits of axis {} are {:g} to {:g} mm: "
                    "stay inside, or "
                    "change them in the cell file",
                    axis.channel.name(), q_mm[i], axis.device_axis, axis.min_mm, axis.max_mm));
  }
  if (axes.size() != q_mm.size())
    return fail(ErrorCode::invalid_argument, reasons::kAxisCount,
                fmt::format("{} motor coordinates were given, the cell has {} axes", q_mm.size(),
                            axes.size()));
  return {};
}

namespace {

Awaitable<Result<Arrival>> move_and_settle(RunScope& scope, const std::vector<double>& q_mm,
                                           const AxesToMove& moved) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.bench.devices.start_move(q_mm, moved));
  auto arrival = co_await wait_in_position(scope, q_mm, moved);
  if (!arrival || arrival->trouble != Trouble::none) co_return arrival;
  scope.phase("settling");
  co_return co_await wait_quiet(scope, *arrival, moved);
}

// Every movement of the axes is in the path.
void note_passage(RunScope& scope, const std::vector<double>& from_mm,
                  const std::vector<double>& commanded_mm, const Arrival& arrival) {
  if (largest_distance_nm(from_mm, arrival.q_mm, {}) <= scope.rules.in_position_nm) return;
  scope.passed.push_back({arrival.in_position.utc,
                          arrival.in_position,
                          commanded_mm,
                          arrival.q_mm,
                          scope.bench.loading.known_n(),
                          {}});
}

Awaitable<Result<Arrival>> go_straight(RunScope& scope, const std::vector<double>& from_mm,
                                       std::vector<double> q_mm, std::string cause,
                                       AxesToMove moved) {
  scope.at_rest.reset();
  note_sides(scope, from_mm, q_mm);
  scope.bench.writer.add(
      MoveRecord{scope.run, scope.bench.clock.now(), from_mm, q_mm, std::move(cause)});
  auto arrival = co_await move_and_settle(scope, q_mm, moved);
  if (arrival && scope.run) note_passage(scope, from_mm, q_mm, *arrival);
  if (scope.run || (arrival && arrival->trouble == Trouble::none)) co_return arrival;
  if (!arrival) {
    auto halting = halted_by_hand(scope, arrival.error());
    co_return tl::unexpected(co_await std::move(halting));
  }
  auto halting = halt_by_hand(scope);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(halting));
  co_return arrival;
}

AxesToMove axes_of_robot(const CellDescription& cell, const std::string& robot) {
  AxesToMove moved;
  for (const auto& axis : cell.motor_channels())
    moved.named.push_back(robot_of(axis.symbol) == robot);
  return moved;
}

}  // namespace

void note_sides(RunScope& scope, const std::vector<double>& from_mm,
                const std::vector<double>& to_mm) {
  scope.sides.resize(to_mm.size(), '?');
  for (std::size_t i = 0; i < std::min(from_mm.size(), to_mm.size()); ++i) {
    const double away_nm = nm_from_mm(from_mm[i] - to_mm[i]);
    if (std::abs(away_nm) > scope.rules.in_position_nm) scope.sides[i] = away_nm > 0 ? '+' : '-';
  }
}

Awaitable<Result<Arrival>> go_to(RunScope& scope, std::vector<double> q_mm, std::string cause,
                                 AxesToMove moved) {
  const auto& cell = scope.bench.description;
  DRIFTWISE_CO_RETURN_IF_ERROR(check_soft_limits(cell, q_mm, moved));
  DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
  scope.phase("moving");
  DRIFTWISE_CO_TRY(auto from, co_await state_before(scope, moved));
  for (std::size_t i = 0; i < std::min(q_mm.size(), from.q_mm.size()); ++i)
    if (is_missing(q_mm[i])) q_mm[i] = from.q_mm[i];
  if (const auto room = check_keep_out(cell, from.q_mm, q_mm); !room) {
    // By hand the person says who moves first.
    if (!scope.run) co_return tl::unexpected(room.error());
    DRIFTWISE_CO_TRY(from, co_await state_before(scope, no_axes(cell)));
    const auto first = first_to_move(cell, from.q_mm, q_mm);
    if (!first) co_return tl::unexpected(room.error());
    const auto of_first = axes_of_robot(cell, *first);
    auto between_mm = from.q_mm;
    for (std::size_t i = 0; i < std::min(q_mm.size(), between_mm.size()); ++i)
      if (of_first.contains(i)) between_mm[i] = q_mm[i];
    DRIFTWISE_CO_TRY(auto arrival, co_await go_straight(scope, from.q_mm, std::move(between_mm),
                                                        cause + ", makes room", of_first));
    if (arrival.trouble != Trouble::none) co_return arrival;
    DRIFTWISE_CO_TRY(from, co_await scope.bench.devices.motion_state());
    DRIFTWISE_CO_RETURN_IF_ERROR(check_keep_out(cell, from.q_mm, q_mm));
  }
  co_return co_await go_straight(scope, from.q_mm, std::move(q_mm), std::move(cause), moved);
}

}  // namespace driftwise::application
