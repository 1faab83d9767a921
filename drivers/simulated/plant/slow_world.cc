#include "drivers/simulated/plant/slow_world.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {
namespace {

constexpr std::int64_t kFrames = 2048;

std::vector<LinkParameters> with_peltier(const PlantParameters& p) {
  std::vector<LinkParameters> links = p.links;
  links.push_back({.name = "peltier",
                   .from = p.stabiliser.part,
                   .to = p.stabiliser.sink_part,
                   .conductance_w_k = p.stabiliser.conductance_w_k});
  return links;
}

double mix(double a, double b, double share) { return a + share * (b - a); }

}  // namespace

SlowWorld::SlowWorld(const PlantParameters& p, std::uint64_t seed)
    : parameters_(p),
      start_s_(-3600 * p.start_hours_before - 2 * kStep_s),
      room_(p.room, seed, start_s_, kStep_s),
      network_(p.parts, with_peltier(p), kStep_s, room_.weather().room_degc),
      stabiliser_(p.stabiliser, seed, kStep_s, room_.weather().room_degc),
      hold_(p.axis.hold_wander_nm, p.axis.hold_wander_s, kStep_s, Random(seed, "axis.hold")),
      instability_(p.interferometer.instability_nm, p.interferometer.instability_s, kStep_s,
                   Random(seed, "interferometer.instability")),
      // Beam against probe: eddies, of the room turbulence's time scale.
      beam_air_(p.interferometer.beam_turbulence_k, p.room.turbulence_s, kStep_s,
                Random(seed, "interferometer.beam_air")),
      burst_random_(seed, "interferometer.burst"),
      burst_start_s_(start_s_),
      burst_end_s_(start_s_),
      air_probe_keep_(std::exp(-kStep_s / p.interferometer.air_probe_s)),
      air_probe_degc_(room_.weather().room_degc),
      frames_(kFrames) {
  probe_degc_.fill(air_probe_degc_);
  for (std::size_t i = 0; i < p.thermometers.size(); ++i) {
    probe_keep_[i] = std::exp(-kStep_s / p.thermometers[i].lag_s);
  }
  keep_frame();
  advance_to(0, [](double) { return 0.0; });
}

void SlowWorld::advance_to(double time_s, const std::function<double(double)>& motor_w) {
  const auto wanted = static_cast<std::int64_t>(std::floor((time_s - start_s_) / kStep_s));
  while (steps_ < wanted) {
    step(motor_w(start_s_ + (static_cast<double>(steps_) + 0.5) * kStep_s));
  }
}

void SlowWorld::step(double motor_w) {
  const auto& p = parameters_;
  const NodeTemperatures& degc = network_.degc();
  room_.step();
  const PeltierHeat peltier =
      stabiliser_.step(degc[static_cast<std::size_t>(p.stabiliser.part)],
                       degc[static_cast<std::size_t>(p.stabiliser.sink_part)]);
  NodeTemperatures power_w{};
  power_w[static_cast<std::size_t>(p.stabiliser.part)] += peltier.support_w;
  power_w[static_cast<std::size_t>(p.stabiliser.sink_part)] += peltier.sink_w;
  power_w[static_cast<std::size_t>(p.axis.motor_part)] += motor_w;
  network_.step(room_.weather().room_degc, power_w);
  hold_.step();
  instability_.step();
  beam_air_.step();

  const double air_degc = degc[static_cast<std::size_t>(p.interferometer.air_part)];
  air_probe_degc_ = air_degc + air_probe_keep_ * (air_probe_degc_ - air_degc);
  for (std::size_t i = 0; i < p.thermometers.size(); ++i) {
    const auto& probe = p.thermometers[i];
    double part_degc = 0;
    for (const int part : probe.parts) part_degc += degc[static_cast<std::size_t>(part)];
    part_degc /= static_cast<double>(probe.parts.size());
    const double felt_degc = mix(part_degc, air_degc, probe.stem);
    probe_degc_[i] = felt_degc + probe_keep_[i] * (probe_degc_[i] - felt_degc);
  }
  ++steps_;
  keep_frame();
}

// Poisson arrivals, drawn one ahead.
double SlowWorld::next_burst_nm() {
  const auto& p = parameters_.interferometer;
  if (p.disturbances_per_hour <= 0) return 0;
  const double time_s = start_s_ + static_cast<double>(steps_) * kStep_s;
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
  frame.air_probe_degc = air_probe_degc_;
  frame.beam_air_k = beam_air_.value();
  frame.instability_nm = instability_.value();
  frame.burst_nm = next_burst_nm();
  frame.hold_wander_nm = hold_.value();
}

const Frame& SlowWorld::frame(std::int64_t step) const {
  const std::int64_t oldest = std::max<std::int64_t>(0, steps_ - kFrames + 1);
  return frames_[static_cast<std::size_t>(std::clamp(step, oldest, steps_) % kFrames)];
}

Frame SlowWorld::at(double time_s) const {
  const double place = (time_s - start_s_) / kStep_s - 1;
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
  blend(mixed_frame.air_probe_degc, next.air_probe_degc);
  blend(mixed_frame.beam_air_k, next.beam_air_k);
  blend(mixed_frame.instability_nm, next.instability_nm);
  blend(mixed_frame.hold_wander_nm, next.hold_wander_nm);
  return mixed_frame;
}

}  // namespace driftwise::simulated
