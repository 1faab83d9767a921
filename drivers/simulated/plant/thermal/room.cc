#include "drivers/simulated/plant/thermal/room.h"

#include <cmath>
#include <numbers>

namespace driftwise::simulated {

Room::Room(const RoomParameters& p, std::uint64_t seed, double start_s, double step_s)
    : parameters_(p),
      time_s_(start_s),
      step_s_(step_s),
      air_degc_((p.ac_w_k * p.set_point_degc + p.wall_w_k * p.balance_degc) /
                (p.ac_w_k + p.wall_w_k)),
      mass_degc_(air_degc_),
      cycle_length_s_(p.cycle_s),
      cycle_random_(seed, "room.cycle"),
      load_w_(p.wander_w, p.wander_s, step_s, Random(seed, "room.load")),
      turbulence_k_(p.turbulence_k, p.turbulence_s, step_s, Random(seed, "room.turbulence")),
      // Two equal first-order smoothings of white noise: the second takes half of the variance.
      pressure_drive_hpa_(p.pressure_wander_hpa * std::numbers::sqrt2, p.pressure_wander_h * 3600,
                          step_s, Random(seed, "room.pressure")),
      humidity_pct_(p.humidity_wander_pct, p.humidity_wander_h * 3600, step_s,
                    Random(seed, "room.humidity")),
      pressure_hpa_(pressure_drive_hpa_.value() / 2) {}

double Room::set_point_degc() const {
  double degc = parameters_.set_point_degc;
  for (const auto& change : parameters_.schedule) {
    if (time_s_ >= change.hours * 3600) degc = change.degc;
  }
  return degc;
}

bool Room::conditioned() const { return time_s_ < parameters_.ac_off_hours * 3600; }

// A valve that hunts about its position: a sine whose length differs from cycle to cycle.
double Room::cycling_w() {
  cycle_phase_ += step_s_ / cycle_length_s_;
  if (cycle_phase_ >= 1) {
    cycle_phase_ -= 1;
    const double spread = parameters_.cycle_spread * cycle_random_.gaussian();
    cycle_length_s_ = parameters_.cycle_s * std::exp(spread);
  }
  return parameters_.cycle_w * std::sin(2 * std::numbers::pi * cycle_phase_);
}

void Room::step() {
  const auto& p = parameters_;
  const double conditioned_w =
      conditioned() ? p.ac_w_k * (set_point_degc() - air_degc_) + cycling_w() : 0;
  const double into_air_w =
      conditioned_w + p.air_mass_w_k * (mass_degc_ - air_degc_) + load_w_.step();
  const double into_mass_w =
      p.air_mass_w_k * (air_degc_ - mass_degc_) + p.wall_w_k * (p.balance_degc - mass_degc_);
  // Explicit: the fastest time constant, air_j_k / conductances, is minutes; the step is a tenth of
  // a second.
  air_degc_ += step_s_ * into_air_w / p.air_j_k;
  mass_degc_ += step_s_ * into_mass_w / p.mass_j_k;
  turbulence_k_.step();
  pressure_hpa_ +=
      step_s_ / (p.pressure_wander_h * 3600) * (pressure_drive_hpa_.step() - pressure_hpa_);
  humidity_pct_.step();
  time_s_ += step_s_;
}

Weather Room::weather() const {
  return {.room_degc = air_degc_ + turbulence_k_.value(),
          .pressure_hpa = parameters_.pressure_hpa + pressure_hpa_,
          .humidity_pct = parameters_.humidity_pct + humidity_pct_.value()};
}

}  // namespace driftwise::simulated
