#pragma once
// Everything with a memory, on one grid of 0.1 s, with the last 200 s kept to look up.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/simulated/plant/room.h"
#include "drivers/simulated/plant/stabiliser_loop.h"
#include "drivers/simulated/plant/thermal_network.h"

namespace driftwise::simulated {

inline constexpr std::size_t kMaxProbes = 16;

// The plant's slow quantities at one instant.
struct Frame {
  NodeTemperatures degc{};                      // thermal nodes
  std::array<double, kMaxProbes> probe_degc{};  // what each thermometer's element feels
  Weather weather;
  double air_probe_degc = 0;  // the interferometer's own, with its lag
  double beam_air_k = 0;      // beam path less the air around it
  double instability_nm = 0;  // slow error of the interferometer
  double burst_nm = 0;        // shaking by a door, a lift: 0 but now and then
  double hold_wander_nm = 0;  // slow servo error
};

class SlowWorld {
 public:
  static constexpr double kStep_s = 0.1;

  // Warmed up to time 0 (the epoch) by parameters.start_hours_before with the motor at rest.
  SlowWorld(const PlantParameters& parameters, std::uint64_t seed);

  // Takes all steps that end at or before time_s. motor_w(t): heat of the motor at an instant since
  // the epoch.
  void advance_to(double time_s, const std::function<double(double)>& motor_w);

  // Interpolated between the two steps before time_s (a constant delay of one step: nothing here is
  // that fast).
  Frame at(double time_s) const;

  StabiliserLoop& stabiliser() { return stabiliser_; }
  const StabiliserLoop& stabiliser() const { return stabiliser_; }

 private:
  void step(double motor_w);
  void keep_frame();
  double next_burst_nm();
  const Frame& frame(std::int64_t step) const;

  const PlantParameters& parameters_;
  double start_s_;
  std::int64_t steps_ = 0;
  Room room_;
  ThermalNetwork network_;
  StabiliserLoop stabiliser_;
  Wander hold_, instability_, beam_air_;
  Random burst_random_;
  double burst_start_s_ = 0, burst_end_s_ = 0, burst_size_nm_ = 0;
  std::array<double, kMaxProbes> probe_keep_{}, probe_degc_{};
  double air_probe_keep_, air_probe_degc_;
  std::vector<Frame> frames_;  // ring, index = step
};

}  // namespace driftwise::simulated
