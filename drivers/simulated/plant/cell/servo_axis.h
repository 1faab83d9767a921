#pragma once
// The servo: what the scale is made to read at any instant, as a closed formula of time over a list
// of moves.
//
// Coordinates: "scale" is the rule's own, 0 at its reference mark; "counter" = scale - counter_zero
// is what the controller shows. Before referencing the counter counts from where the axis stood at
// power-on. A move: start delay, profile, ring-down, then the holding error: a dead band of the
// controller's integrator, so that every approach ends 25..35 nm off on either side, plus a slow
// wander (handed in by the caller, from its grid).

#include <cstdint>
#include <deque>
#include <functional>

#include "drivers/simulated/plant/numbers/quintic.h"
#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

class ServoAxis {
 public:
  ServoAxis(const AxisParameters& parameters, std::uint64_t seed, int index = 0);

  void start_move(double target_mm, double now_s);
  void set_velocity(double mm_per_s) { velocity_mm_s_ = mm_per_s; }
  void set_servo(bool on, double now_s);
  void start_reference(double now_s);
  void halt(double now_s);
  // Something outside pushes the stage by so much, nm at a time in s: contact, a knock.
  void set_push(std::function<double(double)> push_nm) { push_nm_ = std::move(push_nm); }

  struct Position {
    double scale_mm = 0;    // true, on the rule
    double counter_mm = 0;  // before quantisation and jitter
    double mm_s2 = 0;
    double approach = 0;     // sign of the move
    double since_end_s = 0;  // since the profile's end, 0 before it
  };
  // Any instant of the last few moves; wander_nm is the slow servo error then.
  Position at(double time_s, double wander_nm) const;

  AxisState state(double now_s) const;  // without q_mm
  double commanded_mm() const { return commanded_mm_; }
  double motor_w(double time_s) const;

 private:
  struct Move {
    Quintic profile;  // scale coordinates
    double counter_zero_mm = 0;
    double hold_nm = 0, ring_nm = 0, approach = 0;
    bool servo = true, reference = false;
  };
  const Move& move_at(double time_s) const;
  void push(Move move);
  Kinematics motion(double time_s) const;
  double settled_s(const Move& move) const;
  void move_to(double scale_mm, double start_s, bool reference);

  AxisParameters parameters_;
  Random random_;
  std::deque<Move> moves_;  // by start; the last ones only
  double velocity_mm_s_;
  double commanded_mm_ = 0;
  double reference_end_s_ = 0;
  bool ever_referenced_ = false;
  std::function<double(double)> push_nm_;
};

}  // namespace driftwise::simulated
