#pragma once

namespace driftwise::simulated {

// Position, velocity, acceleration along the axis: mm, mm/s, mm/s2.
struct Kinematics {
  double mm = 0, mm_s = 0, mm_s2 = 0;
};

// The profile of least jerk from any state to rest (Flash & Hogan 1985): a polynomial of degree
// five.
class Quintic {
 public:
  Quintic() = default;
  // Starts at start_s in the given state, rests at end_mm after duration_s (> 0).
  Quintic(double start_s, const Kinematics& from, double end_mm, double duration_s);
  Kinematics at(double time_s) const;  // outside the profile: its ends, at rest after it
  double start_s() const { return start_s_; }
  double end_s() const { return start_s_ + duration_s_; }
  double end_mm() const { return end_mm_; }

 private:
  double start_s_ = 0, duration_s_ = 1, end_mm_ = 0;
  double c_[6] = {};  // in the reduced time (t - start) / duration
};

// How long a rest-to-rest profile takes: peak velocity 15/8 D/T and peak acceleration 10/sqrt(3)
// D/T^2 within limits.
double quintic_duration_s(double distance_mm, double velocity_mm_s, double acceleration_mm_s2);

}  // namespace driftwise::simulated
