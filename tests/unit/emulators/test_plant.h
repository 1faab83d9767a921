#pragma once
// A plant of a few lines, so that an emulator's test says by itself what the world does: axes move
// at constant velocity, probes read what they are told, readings have no noise.

#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "drivers/simulated/emulators/timeline.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class TestPlant : public Plant {
 public:
  explicit TestPlant(int axes = 1) : axes_(static_cast<std::size_t>(axes)) {
    for (int i = 1; i <= 10; ++i) ohm[100 + i] = 1080.0 + i;
  }
  // What the tests set and look at.
  std::map<int, double> ohm;
  double length_nm = 1234.5678;
  bool beam_broken = false, laser_stable = true;
  int zeroed = 0;
  double dead_path_mm = 0;
  std::vector<StabiliserState> zones{{22.5, 23.0, 12.5, 0.0, false},
                                     {19.0, 20.0, 0.0, 30.0, false}};
  StabiliserMode mode = StabiliserMode::automatic;
  double manual_pct = 0, heat_band_k = 0, integral_s = 0;
  AngleReading angle{12.342, -5.0, false, false, 0};
  LoadState hanging{0, true, false, 3.85};
  TimeNs latest = 0;  // time never runs back

  void advance_to(TimeNs now) override { look(now); }
  int axis_count() const override { return static_cast<int>(axes_.size()); }
  AxisState axis(int index, TimeNs now) override {
    look(now);
    const One& a = one(index);
    AxisState state;
    const double way = a.target - a.from, gone = seconds_between(a.start, now) * a.velocity;
    state.moving = std::abs(way) > gone;
    state.q_mm = state.moving ? a.from + (way > 0 ? gone : -gone) : a.target;
    state.commanded_mm = a.target;
    state.on_target = !state.moving;
    state.referencing = a.referenced_from > now;
    state.referenced = a.referenced_from != 0 && a.referenced_from <= now;
    state.servo = a.servo;
    return state;
  }
  AxisTravel axis_travel(int) const override { return {-5, 5}; }
  void start_move(int index, double target, TimeNs now) override {
    const double here = axis(index, now).q_mm;
    One& a = one(index);
    a.from = here, a.target = target, a.start = now;
  }
  void set_velocity(int index, double v, TimeNs now) override {
    look(now), one(index).velocity = v;
  }
  void set_servo(int index, bool on, TimeNs now) override { look(now), one(index).servo = on; }
  void start_reference(int index, TimeNs now) override {
    look(now);
    one(index) = {0, 0, now, one(index).velocity, now + 3 * kSecondNs, one(index).servo};
  }
  void halt_axis(int index, TimeNs now) override { start_move(index, axis(index, now).q_mm, now); }

  int interferometer_count() const override { return 2; }
  LengthReading measure_length(int index, TimeNs start, int samples) override {
    const TimeNs end = start + nanoseconds_from(samples / sample_rate_hz());
    look(end);
    return {length_nm + index, 3.5, 20.25, 1.5, 85, beam_broken, laser_stable, start, end};
  }
  double sample_rate_hz() const override { return 4096; }
  void zero_length(int index, TimeNs now) override {
    look(now), zeroed |= 1 << index, beam_broken = false;
  }
  void set_dead_path_mm(int, double mm) override { dead_path_mm = mm; }

  int collimator_count() const override { return 2; }
  AngleReading measure_angle(int, double, TimeNs end) override { return look(end), angle; }
  bool has_load() const override { return true; }
  LoadState load(TimeNs now) override { return look(now), hanging; }
  void set_load(double newton, TimeNs now) override {
    look(now), hanging.newton = newton, hanging.resting = false;
  }

  double probe_ohm(int input, TimeNs now) override {
    look(now);
    return ohm.contains(input) ? ohm[input] : std::numeric_limits<double>::quiet_NaN();
  }
  bool has_probe(int input) const override { return ohm.contains(input); }

  int stabiliser_count() const override { return static_cast<int>(zones.size()); }
  StabiliserState stabiliser(int index, TimeNs now) override {
    return look(now), zones[static_cast<std::size_t>(index)];
  }
  void set_set_point_degc(int index, double degc, TimeNs now) override {
    look(now), zones[static_cast<std::size_t>(index)].set_point_degc = degc;
  }
  void set_stabiliser_mode(int, StabiliserMode m, double pct, TimeNs now) override {
    look(now), mode = m, manual_pct = pct;
  }
  void set_stabiliser_tuning(int, double heat, double, double ti, double, TimeNs now) override {
    look(now), heat_band_k = heat, integral_s = ti;
  }

 private:
  struct One {
    double from = 0, target = 0;
    TimeNs start = 0;
    double velocity = 1;
    TimeNs referenced_from = 0;
    bool servo = false;
  };
  One& one(int index) { return axes_[static_cast<std::size_t>(index)]; }
  void look(TimeNs now) { latest = std::max(latest, now); }
  std::vector<One> axes_;
};

}  // namespace driftwise::simulated
