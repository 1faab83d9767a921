#include "server/application/motion/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

constexpr double kPoll_s = 0.1;

double largest_distance_nm(const std::vector<double>& a_mm, const std::vector<double>& b_mm) {
  double largest = a_mm.size() == b_mm.size() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a_mm.size(), b_mm.size()); ++i) {
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
  explicit QuietWindow(double settle_s) : length_(nanoseconds_from_s(settle_s)) {}
  void add(const MotionState& state) {
    seen_.push_back(state);
    // One sample at or before the window's begin is kept: it shows that the window is full.
    while (seen_.size() > 1 && state.at - seen_[1].at >= length_) seen_.pop_front();
  }
  bool full() const { return !seen_.empty() && seen_.back().at - seen_.front().at >= length_; }
  double peak_to_peak_nm() const {
    double widest = 0;
    for (std::size_t axis = 0; axis < seen_.front().q_mm.size(); ++axis) {
      const auto [low, high] = std::minmax_element(
          seen_.begin(), seen_.end(),
          [axis](const auto& a, const auto& b) { return a.q_mm[axis] < b.q_mm[axis]; });
      widest = std::max(widest, nm_from_mm(high->q_mm[axis] - low->q_mm[axis]));
    }
    return widest;
  }

 private:
  Nanoseconds length_;
  std::deque<MotionState> seen_;
};

Awaitable<Result<Arrival>> wait_in_position(RunScope& scope, const std::vector<double>& q_mm) {
  const auto limit = scope.bench.clock.now().utc + nanoseconds_from_s(scope.rules.move_timeout_s);
  while (true) {
    DRIFTWISE_CO_TRY(auto state, co_await scope.bench.devices.motion_state());
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
    const double off_nm = largest_distance_nm(state.q_mm, q_mm);
    const auto now = scope.bench.clock.now();
    if (!state.moving && state.on_target && off_nm <= scope.rules.in_position_nm) {
      scope.bench.doubts.readback_is_good();
      co_return Arrival{Trouble::none, "", now};
    }
    if (now.utc > limit && !state.moving && state.on_target) {
      // No servo that holds badly is so far away: then the run waits.
      constexpr double kFarAway = 10;
      const auto off = scope.bench.doubts.readback_is_off(
          fmt::format("the controller says that it is on target, its readback is {:.4g} nm from "
                      "the commanded position (limit {:g} nm): look at the scale and its reference",
                      off_nm, scope.rules.in_position_nm));
      if (off_nm > kFarAway * scope.rules.in_position_nm) co_return tl::unexpected(off.error());
    }
    if (now.utc > limit)
      co_return Arrival{
          Trouble::not_settled,
          fmt::format("{:.0f} nm from the commanded position after {:g} s, limit {:g} nm{}", off_nm,
                      scope.rules.move_timeout_s, scope.rules.in_position_nm,
                      state.moving      ? ", still moving"
                      : state.on_target ? ""
                                        : ", not on target"),
          now};
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.sleep_s(kPoll_s));
  }
}

Awaitable<Result<Arrival>> wait_quiet(RunScope& scope, Arrival arrival) {
  if (scope.rules.settle_s <= 0) co_return arrival;
  const auto limit =
      scope.bench.clock.now().utc +
      nanoseconds_from_s(std::max(scope.rules.move_timeout_s, 2 * scope.rules.settle_s));
  const double poll_s = std::max(0.05, scope.rules.settle_s / 8);
  QuietWindow window(scope.rules.settle_s);
  while (true) {
    DRIFTWISE_CO_TRY(auto state, co_await scope.bench.devices.motion_state());
    window.add(state);
    if (window.full()) {
      const double peak_to_peak_nm = window.peak_to_peak_nm();
      if (peak_to_peak_nm <= scope.rules.quiet_nm) co_return arrival;
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

Result<void> check_soft_limits(const CellDescription& description,
                               const std::vector<double>& q_mm) {
  std::size_t i = 0;
  for (const auto& device : description.devices) {
    for (const auto& axis : device.axes()) {
      if (i >= q_mm.size())
        return fail(ErrorCode::invalid_argument, reasons::kAxisCount,
                    fmt::format("{} motor coordinates were given, {} is missing", q_mm.size(),
                                axis.channel.name()));
      const double q = q_mm[i++];
      if (!(q >= axis.min_mm && q <= axis.max_mm))
        return fail(
            ErrorCode::out_of_range, reasons::kSoftLimit,
            fmt::format("{} = {} mm was asked for, the soft limits of axis {} are {:g} to {:g} mm: "
                        "stay inside, or "
                        "change them in the cell file",
                        axis.channel.name(), q, axis.device_axis, axis.min_mm, axis.max_mm));
    }
  }
  if (i != q_mm.size())
    return fail(
        ErrorCode::invalid_argument, reasons::kAxisCount,
        fmt::format("{} motor coordinates were given, the cell has {} axes", q_mm.size(), i));
  return {};
}

Awaitable<Result<Arrival>> go_to(RunScope& scope, std::vector<double> q_mm, std::string cause) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check_soft_limits(scope.bench.description, q_mm));
  DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
  scope.phase("moving");
  DRIFTWISE_CO_TRY(const auto from, co_await scope.bench.devices.motion_state());
  scope.bench.writer.add(
      MoveRecord{scope.run, scope.bench.clock.now(), from.q_mm, q_mm, std::move(cause)});
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.bench.devices.start_move(q_mm));
  auto arrival = co_await wait_in_position(scope, q_mm);
  if (!arrival || arrival->trouble != Trouble::none) co_return arrival;
  scope.phase("settling");
  co_return co_await wait_quiet(scope, *arrival);
}

}  // namespace driftwise::application
