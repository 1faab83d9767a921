#include "drivers/simulated/plant/cell/slow_world.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {
namespace {

constexpr std::int64_t kFrames = 2048;
constexpr double kAirHeatPerVolume_j_m3k = 1.2 * 1005;  // density x heat capacity at 20 degC

std::vector<LinkParameters> with_peltiers(const CellParameters& p) {
  std::vector<LinkParameters> links = p.links;
  for (const auto& stabiliser : p.stabilisers) {
    links.push_back({.name = "peltier",
                     .from = stabiliser.part,
                     .to = stabiliser.sink_part,
                     .conductance_w_k = stabiliser.conductance_w_k});
  }
  return links;
}

double mix(double a, double b, double share) { return a + share * (b - a); }

}  // namespace

SlowWorld::SlowWorld(const CellParameters& p, std::uint64_t seed)
    : parameters_(p),
      step_s_(p.step_s),
      start_s_(-3600 * p.start_hours_before - 2 * step_s_),
      box_open_until_s_(start_s_),
      room_(p.room, seed, start_s_, step_s_),
      network_(p.parts, with_peltiers(p), step_s_, room_.weather().room_degc),
      burst_random_(seed, "interferometer.burst"),
      burst_start_s_(start_s_),
      burst_end_s_(start_s_),
      frames_(kFrames) {
  const double start_degc = room_.weather().room_degc;
  for (int i = 0; i < static_cast<int>(p.stabilisers.size()); ++i) {
    stabilisers_.emplace_back(p.stabilisers[static_cast<std::size_t>(i)], seed, step_s_, start_degc,
                              i);
  }
  for (int i = 0; i < static_cast<int>(p.axes.size()); ++i) {
    const auto& axis = p.axes[static_cast<std::size_t>(i)];
    holds_.emplace_back(axis.hold_wander_nm, axis.hold_wander_s, step_s_,
                        Random(seed, stream_of("axis.hold", i)));
  }
  for (int i = 0; i < static_cast<int>(p.interferometers.size()); ++i) {
    const auto& beam = p.interferometers[static_cast<std::size_t>(i)];
    beams_.push_back({.instability = {beam.instability_nm, beam.instability_s, step_s_,
                                      Random(seed, stream_of("interferometer.instability", i))},
                      // Beam against probe: eddies, of the room turbulence's time scale.
                      .beam_air = {beam.beam_turbulence_k, p.room.turbulence_s, step_s_,
                                   Random(seed, stream_of("interferometer.beam_air", i))},
                      .air_probe_keep = std::exp(-step_s_ / beam.air_probe_s),
                      .air_probe_degc = start_degc});
  }
  probe_degc_.fill(start_degc);
  for (std::size_t i = 0; i < p.thermometers.size(); ++i) {
    probe_keep_[i] = std::exp(-step_s_ / p.thermometers[i].lag_s);
  }
  std::vector<double> wavelength_nm;
  for (const auto& beam : p.interferometers) wavelength_nm.push_back(beam.wavelength_nm);
  hidden_ = hidden_mechanisms(p.hidden, seed, step_s_, start_degc, wavelength_nm);
  keep_frame();
  // At rest where the axes stand at power-on.
  advance_to(0, {.motor_w = [](std::size_t, double) { return 0.0; },
                 .scale_mm = [&p](std::size_t axis, double,
                                  double) { return p.axes[axis].reference_offset_mm; }});
}

void SlowWorld::advance_to(double time_s, const Motors& motors) {
  const auto wanted = static_cast<std::int64_t>(std::floor((time_s - start_s_) / step_s_));
  while (steps_ < wanted) step(motors);
}

void SlowWorld::step(const Motors& motors) {
  const auto& p = parameters_;
  const NodeTemperatures& degc = network_.degc();
  const double middle_s = start_s_ + (static_cast<double>(steps_) + 0.5) * step_s_;
  room_.step();
  NodeTemperatures power_w{};
  for (std::size_t i = 0; i < stabilisers_.size(); ++i) {
    const auto part = static_cast<std::size_t>(p.stabilisers[i].part);
    const auto sink = static_cast<std::size_t>(p.stabilisers[i].sink_part);
    const PeltierHeat peltier = stabilisers_[i].step(degc[part], degc[sink]);
    power_w[part] += peltier.support_w;
    power_w[sink] += peltier.sink_w;
  }
  for (std::size_t i = 0; i < p.axes.size(); ++i) {
    power_w[static_cast<std::size_t>(p.axes[i].motor_part)] += motors.motor_w(i, middle_s);
  }
  if (middle_s < box_open_until_s_) {
    const auto air = static_cast<std::size_t>(p.box_air_part);
    power_w[air] += p.box_open_flow_m3_h / 3600 * kAirHeatPerVolume_j_m3k *
                    (room_.weather().room_degc - degc[air]);
  }
  network_.step(room_.weather().room_degc, power_w);
  for (auto& hold : holds_) hold.step();
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    auto& beam = beams_[i];
    beam.instability.step();
    beam.beam_air.step();
    const double air_degc = degc[static_cast<std::size_t>(p.interferometers[i].air_part)];
    beam.air_probe_degc = air_degc + beam.air_probe_keep * (beam.air_probe_degc - air_degc);
  }
  for (std::size_t i = 0; i < p.thermometers.size(); ++i) {
    const auto& probe = p.thermometers[i];
    double part_degc = 0;
    for (const int part : probe.parts) part_degc += degc[static_cast<std::size_t>(part)];
    part_degc /= static_cast<double>(probe.parts.size());
    // The stem stands in the air of the first interferometer: there is one air under the cover.
    const double air_degc = degc[static_cast<std::size_t>(p.interferometers.front().air_part)];
    const double felt_degc = mix(part_degc, air_degc, probe.stem);
    probe_degc_[i] = felt_degc + probe_keep_[i] * (probe_degc_[i] - felt_degc);
  }
  ++steps_;
  if (!hidden_.empty()) step_hidden(motors.scale_mm);
  keep_frame();
}

void SlowWorld::step_hidden(const ScalePlace& scale_mm) {
  const double time_s = start_s_ + static_cast<double>(steps_) * step_s_;
  std::array<double, kMaxAxes> places_mm{};
  for (std::size_t i = 0; i < holds_.size(); ++i) {
    places_mm[i] = scale_mm(i, time_s, holds_[i].value());
  }
  const GridInstant now{.time_s = time_s,
                        .step_s = step_s_,
                        .degc = &network_.degc(),
                        .scale_mm = std::span(places_mm.data(), holds_.size())};
  for (auto& one : hidden_) one.mechanism->step(now);
}

// A front that passes: pressure falls or rises as a smooth step.
double SlowWorld::weather_front_hpa() const {
  const double hours = (start_s_ + static_cast<double>(steps_) * step_s_) / 3600;
  double hpa = 0;
  for (const auto& one : parameters_.hidden) {
    if (const auto* front = std::get_if<HiddenWeatherFront>(&one.effect)) {
      hpa += front->hpa * 0.5 * (1 + std::tanh(2 * (hours - front->at_h) / front->over_h));
    }
  }
  return hpa;
}

// Poisson arrivals, drawn one ahead.
double SlowWorld::next_burst_nm() {
  const auto& p = parameters_.interferometers.front();
  if (p.disturbances_per_hour <= 0) return 0;
  const double time_s = start_s_ + static_cast<double>(steps_) * step_s_;
  if (time_s >= burst_end_s_) {
    burst_start_s_ = time_s - std::log(burst_random_.uniform()) * 3600 / p.disturbances_per_hour;
    burst_end_s_ = burst_start_s_ + burst_random_.uniform(p.disturbance_min_s, p.disturbance_max_s);
    burst_size_nm_ = -std::log(burst_random_.uniform()) * p.disturbance_nm;
  }
  return time_s >= burst_start_s_ ? burst_size_nm_ : 0;
}

void SlowWorld::keep_frame() {
  Frame& frame = frames_[static_cast<std::size_t>(steps_ % kFrames)];
  frame.degc = network_.degc();
  frame.probe_degc = probe_degc_;
  frame.weather = room_.weather();
  if (!parameters_.hidden.empty()) frame.weather.pressure_hpa += weather_front_hpa();
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    frame.beams[i] = {.air_probe_degc = beams_[i].air_probe_degc,
                      .beam_air_k = beams_[i].beam_air.value(),
                      .instability_nm = beams_[i].instability.value()};
  }
  frame.burst_nm = next_burst_nm();
  for (std::size_t i = 0; i < holds_.size(); ++i) frame.hold_wander_nm[i] = holds_[i].value();
  for (std::size_t i = 0; i < hidden_.size(); ++i) frame.hidden[i] = hidden_[i].mechanism->memory();
}

const Frame& SlowWorld::frame(std::int64_t step) const {
  const std::int64_t oldest = std::max<std::int64_t>(0, steps_ - kFrames + 1);
  return frames_[static_cast<std::size_t>(std::clamp(step, oldest, steps_) % kFrames)];
}

Frame SlowWorld::at(double time_s) const {
  const double place = (time_s - start_s_) / step_s_ - 1;
  const auto step = static_cast<std::int64_t>(std::floor(place));
  const double share = place - static_cast<double>(step);
  Frame mixed_frame = frame(step);
  const Frame& next = frame(step + 1);
  const auto blend = [share](double& value, double other) { value = mix(value, other, share); };
  for (std::size_t i = 0; i < kMaxNodes; ++i) blend(mixed_frame.degc[i], next.degc[i]);
  for (std::size_t i = 0; i < kMaxProbes; ++i) {
    blend(mixed_frame.probe_degc[i], next.probe_degc[i]);
  }
  blend(mixed_frame.weather.room_degc, next.weather.room_degc);
  blend(mixed_frame.weather.pressure_hpa, next.weather.pressure_hpa);
  blend(mixed_frame.weather.humidity_pct, next.weather.humidity_pct);
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    auto& beam = mixed_frame.beams[i];
    blend(beam.air_probe_degc, next.beams[i].air_probe_degc);
    blend(beam.beam_air_k, next.beams[i].beam_air_k);
    blend(beam.instability_nm, next.beams[i].instability_nm);
  }
  for (std::size_t i = 0; i < holds_.size(); ++i) {
    blend(mixed_frame.hold_wander_nm[i], next.hold_wander_nm[i]);
  }
  for (std::size_t i = 0; i < hidden_.size(); ++i) blend(mixed_frame.hidden[i], next.hidden[i]);
  return mixed_frame;
}

}  // namespace driftwise::simulated
