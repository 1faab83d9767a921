#pragma once
// Everything with a memory, on one grid of step_s (0.1 s), with the last 2048 steps kept to look
// up.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/simulated/plant/hidden/hidden_mechanism.h"
#include "drivers/simulated/plant/thermal/room.h"
#include "drivers/simulated/plant/thermal/stabiliser_loop.h"
#include "drivers/simulated/plant/thermal/thermal_network.h"

namespace driftwise::simulated {

inline constexpr std::size_t kMaxProbes = 16, kMaxBeams = 3, kMaxAxes = 3;

// The plant's slow quantities at one instant.
struct Frame {
  NodeTemperatures degc{};                      // thermal nodes
  std::array<double, kMaxProbes> probe_degc{};  // what each thermometer's element feels
  Weather weather;
  struct Beam {
    double air_probe_degc = 0;  // the interferometer's own, with its lag
    double beam_air_k = 0;      // beam path less the air around it
    double instability_nm = 0;  // slow error of the interferometer
  };
  std::array<Beam, kMaxBeams> beams{};
  double burst_nm = 0;  // shaking by a door, a lift: 0 but now and then; of the whole table
  std::array<double, kMaxAxes> hold_wander_nm{};  // slow servo error
  std::array<double, kMaxHidden> hidden{};        // memories of the hidden mechanisms, in order
};

class SlowWorld {
 public:
  // Warmed up to time 0 (the epoch) by parameters.start_hours_before with the motors at rest.
  SlowWorld(const CellParameters& parameters, std::uint64_t seed);

  // Takes all steps that end at or before time_s. motor_w(axis, t): heat of a motor at an instant
  // since the epoch. scale_mm(axis, t, wander): where its scale is; asked only when something
  // hidden wants to know.
  using MotorHeat = std::function<double(std::size_t axis, double time_s)>;
  using ScalePlace = std::function<double(std::size_t axis, double time_s, double wander_nm)>;
  struct Motors {
    MotorHeat motor_w;
    ScalePlace scale_mm;
  };
  void advance_to(double time_s, const Motors& motors);

  // Interpolated between the two steps before time_s (a constant delay of one step: nothing here is
  // that fast).
  Frame at(double time_s) const;

  // The box stands open until then: its air mixes with the room's.
  void open_box_until(double time_s) { box_open_until_s_ = time_s; }

  StabiliserLoop& stabiliser(std::size_t index) { return stabilisers_[index]; }
  const std::vector<PlacedMechanism>& hidden() const { return hidden_; }

 private:
  void step(const Motors& motors);
  void step_hidden(const ScalePlace& scale_mm);
  void keep_frame();
  double weather_front_hpa() const;
  double next_burst_nm();
  const Frame& frame(std::int64_t step) const;

  struct BeamWorld {
    Wander instability, beam_air;
    double air_probe_keep, air_probe_degc;
  };

  const CellParameters& parameters_;
  double step_s_, start_s_;
  double box_open_until_s_;
  std::int64_t steps_ = 0;
  Room room_;
  ThermalNetwork network_;
  std::vector<StabiliserLoop> stabilisers_;
  std::vector<Wander> holds_;
  std::vector<BeamWorld> beams_;
  std::vector<PlacedMechanism> hidden_;
  Random burst_random_;
  double burst_start_s_ = 0, burst_end_s_ = 0, burst_size_nm_ = 0;
  std::array<double, kMaxProbes> probe_keep_{}, probe_degc_{};
  std::vector<Frame> frames_;  // ring, index = step
};

}  // namespace driftwise::simulated
