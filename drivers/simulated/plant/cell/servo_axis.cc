#include "drivers/simulated/plant/cell/servo_axis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kMovesKept = 64;  // at one move per seconds, longer than anything looks back
constexpr double kGrip_s = 0.05;        // within which the servo catches the stage after a profile
constexpr double kReferenceMark_mm = 0;
constexpr double kSearch_mm = -0.5;  // the mark is crossed from below

}  // namespace

ServoAxis::ServoAxis(const AxisParameters& parameters, std::uint64_t seed, int index)
    : parameters_(parameters),
      random_(seed, stream_of("axis.servo", index)),
      velocity_mm_s_(parameters.velocity_mm_s) {
  const double at_rest_mm = parameters_.reference_offset_mm;
  push(
      {.profile = Quintic(-1e9, {.mm = at_rest_mm}, at_rest_mm, 1), .counter_zero_mm = at_rest_mm});
}

const ServoAxis::Move& ServoAxis::move_at(double time_s) const {
  for (auto move = moves_.rbegin(); move != moves_.rend(); ++move) {
    if (move->profile.start_s() <= time_s) return *move;
  }
  return moves_.front();
}

// What has not begun yet when a new command comes will never happen.
void ServoAxis::push(Move move) {
  while (!moves_.empty() && moves_.back().profile.start_s() >= move.profile.start_s()) {
    moves_.pop_back();
  }
  moves_.push_back(std::move(move));
  if (moves_.size() > kMovesKept) moves_.pop_front();
}

Kinematics ServoAxis::motion(double time_s) const { return move_at(time_s).profile.at(time_s); }

void ServoAxis::move_to(double scale_mm, double start_s, bool reference) {
  const Kinematics from = motion(start_s);
  const double distance_mm = std::abs(scale_mm - from.mm);
  const double duration_s =
      quintic_duration_s(distance_mm, velocity_mm_s_, parameters_.acceleration_mm_s2);
  const double peak_mm_s2 = 10 / std::sqrt(3.0) * distance_mm / (duration_s * duration_s);
  const double side = random_.uniform() < 0.5 ? -1 : 1;
  push({.profile = Quintic(start_s, from, scale_mm, duration_s),
        .counter_zero_mm = move_at(start_s).counter_zero_mm,
        .hold_nm = side * random_.uniform(parameters_.hold_min_nm, parameters_.hold_max_nm),
        .ring_nm = parameters_.ring_nm_per_mm_s2 * peak_mm_s2,
        .approach = scale_mm >= from.mm ? 1.0 : -1.0,
        .reference = reference});
}

void ServoAxis::start_move(double target_mm, double now_s) {
  commanded_mm_ = target_mm;
  // Searching is over, or given up: then the counter keeps what it had.
  if (now_s < reference_end_s_) {
    reference_end_s_ = 0;
    ever_referenced_ = false;
  }
  const double zero_mm = move_at(now_s).counter_zero_mm;
  move_to(target_mm + zero_mm, now_s + parameters_.start_delay_s, false);
}

void ServoAxis::start_reference(double now_s) {
  commanded_mm_ = 0;
  ever_referenced_ = true;
  reference_end_s_ = now_s + parameters_.reference_s;
  const double start_s = now_s + parameters_.start_delay_s;
  move_to(kSearch_mm, start_s, true);
  move_to(kReferenceMark_mm, now_s + parameters_.reference_s / 2, true);
  // The mark is found to a few nanometres; from then on the counter counts from there.
  const double found_mm = parameters_.reference_repeatability_nm * random_.gaussian() / kNmPerMm;
  move_to(kReferenceMark_mm + found_mm, reference_end_s_, false);
  moves_.back().counter_zero_mm = found_mm;
}

void ServoAxis::halt(double now_s) {
  const Kinematics from = motion(now_s);
  constexpr double kStop_s = 0.05;
  if (now_s < reference_end_s_) {
    reference_end_s_ = 0;
    ever_referenced_ = false;
  }
  const Move& present = move_at(now_s);
  const double end_mm = from.mm + from.mm_s * kStop_s / 2;
  Move stop = present;
  // An axis that stands is at rest at once; a move that has not begun never does.
  const bool stands = now_s >= present.profile.end_s();
  stop.profile = stands ? present.profile : Quintic(now_s, from, end_mm, kStop_s);
  stop.ring_nm = 0;
  stop.reference = false;
  commanded_mm_ = end_mm - stop.counter_zero_mm;
  push(stop);
}

// Without current the flexure goes back to its neutral position.
void ServoAxis::set_servo(bool on, double now_s) {
  Move move = move_at(now_s);
  if (move.servo == on) return;
  const Kinematics from = motion(now_s);
  const double end_mm = on ? from.mm : parameters_.reference_offset_mm;
  move.profile = Quintic(now_s, from, end_mm, on ? 0.05 : 1.0);
  move.hold_nm = move.ring_nm = 0;
  move.reference = false;
  move.servo = on;
  if (on) commanded_mm_ = end_mm - move.counter_zero_mm;
  push(move);
}

ServoAxis::Position ServoAxis::at(double time_s, double wander_nm) const {
  const Move& move = move_at(time_s);
  const Kinematics motion = move.profile.at(time_s);
  const double since_s = std::max(0.0, time_s - move.profile.end_s());
  const double omega = 2 * std::numbers::pi * parameters_.resonance_hz;
  const double ring_nm =
      move.ring_nm * std::exp(-parameters_.damping * omega * since_s) * std::sin(omega * since_s);
  const double grip = 1 - std::exp(-since_s / kGrip_s);
  const double hold_nm = move.servo ? grip * (move.hold_nm + wander_nm) : 0;
  const double push_nm = push_nm_ ? push_nm_(time_s) : 0;
  const double scale_mm = motion.mm + (ring_nm + hold_nm + push_nm) / kNmPerMm;
  return {.scale_mm = scale_mm,
          .counter_mm = scale_mm - move.counter_zero_mm,
          .mm_s2 = motion.mm_s2,
          .approach = move.approach,
          .since_end_s = since_s};
}

// The ring-down's envelope has left the window, and the window time has passed.
double ServoAxis::settled_s(const Move& move) const {
  const double room_nm = std::max(1.0, parameters_.window_nm - std::abs(move.hold_nm));
  const double decay_per_s = parameters_.damping * 2 * std::numbers::pi * parameters_.resonance_hz;
  const double quiet_s =
      move.ring_nm > room_nm ? std::log(move.ring_nm / room_nm) / decay_per_s : 0;
  return move.profile.end_s() + quiet_s + parameters_.window_s;
}

AxisState ServoAxis::state(double now_s) const {
  const Move& present = move_at(now_s);
  const Move& last = moves_.back();
  const bool reached_last = last.profile.start_s() <= now_s;
  const bool referencing = now_s < reference_end_s_;
  return {.commanded_mm = commanded_mm_,
          .moving = now_s < present.profile.end_s() || referencing,
          .on_target = present.servo && reached_last && !referencing && now_s >= settled_s(last),
          .referenced = ever_referenced_ && !referencing,
          .referencing = referencing,
          .servo = present.servo};
}

// Heat of the coil: force to bend the flexures and to accelerate, over the motor constant.
double ServoAxis::motor_w(double time_s) const {
  const Move& move = move_at(time_s);
  if (!move.servo) return 0;
  const Kinematics motion = move.profile.at(time_s);
  const double bent_mm = motion.mm - parameters_.reference_offset_mm;
  const double force_n =
      parameters_.stiffness_n_mm * bent_mm + parameters_.moving_mass_kg * motion.mm_s2 * 1e-3;
  const double root_w = force_n / parameters_.motor_constant_n_sqrtw;
  return root_w * root_w;
}

}  // namespace driftwise::simulated
