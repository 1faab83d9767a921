#include "server/application/recording/motion_watch.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "server/core/units.h"

namespace driftwise::application {

void MotionWatch::commanded(std::vector<double> q_mm) {
  ++orders_;
  expected_ = Expected::under_way;
  elsewhere_ = false;
  q_mm_ = std::move(q_mm);
}

void MotionWatch::released() {
  ++orders_;
  forget();
}

void MotionWatch::lost() {
  if (expected_ == Expected::under_way) released();
}

void MotionWatch::forget() {
  expected_ = Expected::anything;
  q_mm_.clear();
}

std::optional<std::string> MotionWatch::farther_than_limit(const MotionState& state,
                                                           const char* what) const {
  for (std::size_t i = 0; i < q_mm_.size() && i < state.q_mm.size(); ++i) {
    if (std::abs(nm_from_mm(state.q_mm[i] - q_mm_[i])) <= limit_nm_) continue;
    return fmt::format(
        "{} {} mm, read back {:.6f} mm", what,
        fmt::format("{} {:.6f}", i < motors_.size() ? motors_[i].symbol : "axis", q_mm_[i]),
        state.q_mm[i]);
  }
  return std::nullopt;
}

std::optional<MotionFinding> MotionWatch::look(const MotionState& state) {
  using Kind = MotionFinding::Kind;
  // Without current an axis sinks to where springs and weight take it: nobody moved it.
  if (!state.servo_on) {
    const bool was_expected = std::exchange(expected_, Expected::anything) != Expected::anything;
    forget();
    if (!was_expected) return std::nullopt;
    return MotionFinding{Kind::servo_off, state.halted_because.empty()
                                              ? std::string("the controller gives no reason")
                                              : "the controller's reason: " + state.halted_because};
  }
  const bool lost = !state.referenced;
  if (lost && expected_ == Expected::at_rest) forget();  // it counts from somewhere else now
  const bool rests = !state.moving && state.on_target;
  std::optional<std::string> moved;
  auto kind = Kind::moved;
  if (expected_ == Expected::at_rest) {
    moved = farther_than_limit(state, "an axis moved that nobody told to: at rest at");
  } else if (expected_ == Expected::under_way && !state.moving &&
             (rests || !state.halted_because.empty())) {
    const bool is_halt = !state.halted_because.empty();
    auto there = farther_than_limit(
        state, is_halt ? "commanded" : "the controller is on target elsewhere: commanded");
    if (there && is_halt) {
      kind = Kind::halted;
      *there += ": " + state.halted_because;
    }
    const bool was_elsewhere = std::exchange(elsewhere_, there.has_value());
    if (there && !was_elsewhere) return std::nullopt;
    moved = std::move(there);
  } else {
    elsewhere_ = false;
  }
  if (moved) {
    forget();
    return MotionFinding{kind, *std::move(moved)};
  }
  if (rests && expected_ != Expected::at_rest) {
    expected_ = Expected::at_rest;
    q_mm_ = state.q_mm;
  }
  return std::nullopt;
}

}  // namespace driftwise::application
