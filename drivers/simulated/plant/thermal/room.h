#pragma once
// The room and its weather: air conditioning with a set-point schedule, valve cycling, loads,
// draughts; pressure and humidity. A function of seed and step number only.

#include <cstdint>

#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

struct Weather {
  double room_degc = 0;  // air, as it streams along the cover
  double pressure_hpa = 0, humidity_pct = 0;
};

class Room {
 public:
  // start_s: the first step's time since the epoch (negative: warm-up). The room starts in balance
  // with its set-point.
  Room(const RoomParameters& parameters, std::uint64_t seed, double start_s, double step_s);
  void step();
  Weather weather() const;

 private:
  double set_point_degc() const;
  double cycling_w();
  bool conditioned() const;  // the air conditioning is on

  RoomParameters parameters_;
  double time_s_, step_s_;
  double air_degc_, mass_degc_;
  double cycle_phase_ = 0, cycle_length_s_;
  Random cycle_random_;
  Wander load_w_, turbulence_k_;
  Wander pressure_drive_hpa_, humidity_pct_;
  double pressure_hpa_ =
      0;  // deviation: the drive smoothed once more, so that it has a finite rate
};

}  // namespace driftwise::simulated
