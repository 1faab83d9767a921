#include "drivers/simulated/plant/linear_axis_plant.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "drivers/simulated/plant/interferometer.h"
#include "drivers/simulated/plant/measuring_loop.h"
#include "drivers/simulated/plant/servo_axis.h"
#include "drivers/simulated/plant/slow_world.h"
#include "drivers/simulated/plant/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kTick_s = 10;  // rows of the truth log without an occasion

void check(bool good, const char* what) {
  if (!good) throw std::out_of_range(what);  // a bug of the caller, not of the world
}

}  // namespace

struct LinearAxisPlant::State {
  State(PlantParameters p, std::uint64_t seed_, TimeNs epoch_)
      : parameters(std::move(p)),
        seed(seed_),
        epoch(epoch_),
        world(parameters, seed_),
        axis(parameters.axis, seed_),
        interferometer(parameters.interferometer, world.at(0).weather),
        scale_noise(seed_, "axis.scale"),
        length_noise(seed_, "interferometer.reading"),
        scanner_noise(seed_, "scanner") {
    for (const auto& part : parameters.parts) node_names.push_back(part.name);
  }

  double seconds(TimeNs at) const { return static_cast<double>(at - epoch) * 1e-9; }
  double now_s() const { return seconds(now); }

  double disturbed(DisturbancePlace place, DisturbanceContext context) const {
    double sum = 0;
    const auto [first, last] = disturbances.equal_range(place);
    for (auto it = first; it != last; ++it) sum += it->second(context);
    return sum;
  }

  struct Instant {
    Frame frame;
    ServoAxis::Position servo;
    DisturbanceContext context;
    double stage_mm = 0;
    LoopState loop;
    double interferometer_true_nm = 0;
    double shown_nm = 0;  // without the noise of reading
  };
  Instant instant(double time_s) const {
    Instant i;
    i.frame = world.at(time_s);
    i.servo = axis.at(time_s, i.frame.hold_wander_nm);
    i.stage_mm = stage_from_scale_mm(parameters, i.frame.degc, i.servo.scale_mm);
    i.context = {.time_s = time_s,
                 .stage_mm = i.stage_mm,
                 .approach = i.servo.approach,
                 .since_move_s = i.servo.since_end_s};
    if (!disturbances.empty()) {
      // The servo follows the scale, so an error of the scale moves the stage the other way.
      i.stage_mm -= disturbed(DisturbancePlace::scale_nm, i.context) / kNmPerMm;
      i.context.stage_mm = i.stage_mm;
    }
    i.loop = measuring_loop(parameters, i.frame.degc, i.stage_mm);
    i.loop.geometry_nm += disturbed(DisturbancePlace::end_effector_nm, i.context);
    i.interferometer_true_nm = i.loop.interferometer_nm();
    i.shown_nm = interferometer.shown_nm(i.interferometer_true_nm, i.frame) +
                 disturbed(DisturbancePlace::interferometer_nm, i.context);
    return i;
  }

  const ThermometerParameters* probe(int input, std::size_t& index) const {
    for (index = 0; index < parameters.thermometers.size(); ++index) {
      if (parameters.thermometers[index].input == input) return &parameters.thermometers[index];
    }
    return nullptr;
  }

  PlantParameters parameters;
  std::uint64_t seed;
  TimeNs epoch;
  TimeNs now = std::numeric_limits<TimeNs>::min();
  SlowWorld world;
  ServoAxis axis;
  Interferometer interferometer;
  Random scale_noise, length_noise, scanner_noise;
  std::multimap<DisturbancePlace, Disturbance> disturbances;
  std::vector<std::string> node_names;
  bool beam_broken = false, laser_stable = true;
  double true_at_zero_nm = 0;
  std::set<int> open_probes;
  std::unique_ptr<TruthLog> log;
  double next_tick_s = 0;
};

LinearAxisPlant::LinearAxisPlant(PlantParameters parameters, std::uint64_t seed, TimeNs epoch)
    : state_(std::make_unique<State>(std::move(parameters), seed, epoch)) {
  state_->now = epoch;
  const auto start = state_->instant(0);
  state_->interferometer.zero(start.interferometer_true_nm, start.frame, 0);
  state_->true_at_zero_nm = start.interferometer_true_nm;
}

LinearAxisPlant::~LinearAxisPlant() = default;

void LinearAxisPlant::advance_to(TimeNs now) {
  State& s = *state_;
  if (now <= s.now) return;
  const auto motor_w = [&s](double time_s) { return s.axis.motor_w(time_s); };
  // Ticks at their own times, so that their rows do not depend on who asks when.
  while (s.log && s.next_tick_s <= s.seconds(now)) {
    s.world.advance_to(s.next_tick_s, motor_w);
    const TimeNs tick = s.epoch + static_cast<TimeNs>(std::llround(s.next_tick_s * 1e9));
    s.log->append("tick", truth(tick));
    s.next_tick_s += kTick_s;
  }
  s.now = now;
  s.world.advance_to(s.now_s(), motor_w);
}

AxisState LinearAxisPlant::axis(int index, TimeNs now) {
  check(index == 0, "axis: this plant has one, index 0");
  advance_to(now);
  State& s = *state_;
  const double now_s = s.now_s();
  AxisState state = s.axis.state(now_s);
  const auto position = s.axis.at(now_s, s.world.at(now_s).hold_wander_nm);
  const auto& p = s.parameters.axis;
  const double jitter_nm =
      std::hypot(p.scale_noise_nm, p.hold_jitter_nm) * s.scale_noise.gaussian();
  const double grain_mm = p.scale_resolution_nm / kNmPerMm;
  state.q_mm = std::round((position.counter_mm + jitter_nm / kNmPerMm) / grain_mm) * grain_mm;
  return state;
}

double LinearAxisPlant::axis_min_mm(int index) const {
  check(index == 0, "axis: this plant has one, index 0");
  return state_->parameters.axis.min_mm;
}

double LinearAxisPlant::axis_max_mm(int index) const {
  check(index == 0, "axis: this plant has one, index 0");
  return state_->parameters.axis.max_mm;
}

void LinearAxisPlant::start_move(int index, double target_mm, TimeNs now) {
  check(index == 0, "axis: this plant has one, index 0");
  advance_to(now);
  state_->axis.start_move(target_mm, state_->now_s());
}

void LinearAxisPlant::set_velocity(int index, double mm_per_s, TimeNs now) {
  check(index == 0 && mm_per_s > 0, "axis 0 wants a velocity above 0");
  advance_to(now);
  state_->axis.set_velocity(mm_per_s);
}

void LinearAxisPlant::set_servo(int index, bool on, TimeNs now) {
  check(index == 0, "axis: this plant has one, index 0");
  advance_to(now);
  state_->axis.set_servo(on, state_->now_s());
}

void LinearAxisPlant::start_reference(int index, TimeNs now) {
  check(index == 0, "axis: this plant has one, index 0");
  advance_to(now);
  state_->axis.start_reference(state_->now_s());
  if (state_->log) state_->log->append("reference", truth(state_->now));
}

void LinearAxisPlant::halt(TimeNs now) {
  advance_to(now);
  state_->axis.halt(state_->now_s());
}

LengthReading LinearAxisPlant::measure_length(int index, TimeNs start, int samples) {
  check(index == 0 && samples > 0, "interferometer 0 wants at least one sample");
  State& s = *state_;
  const auto& p = s.parameters.interferometer;
  const double length_s = samples / p.sample_rate_hz;
  LengthReading reading{.start = start,
                        .end = start + static_cast<TimeNs>(std::llround(length_s * 1e9))};
  advance_to(reading.end);

  // What changes during the reading is seen at 16 instants; what is faster is noise of the samples.
  constexpr int kInstants = 16;
  double sum_nm = 0, square_nm2 = 0, burst_nm = 0, first_nm = 0;
  for (int k = 0; k < kInstants; ++k) {
    const auto at = s.instant(s.seconds(start) + (k + 0.5) / kInstants * length_s);
    if (k == 0) first_nm = at.shown_nm;
    sum_nm += at.shown_nm - first_nm;
    square_nm2 += (at.shown_nm - first_nm) * (at.shown_nm - first_nm);
    burst_nm = std::max(burst_nm, at.frame.burst_nm);
  }
  const double mean_nm = sum_nm / kInstants;
  const double spread_nm2 = std::max(0.0, square_nm2 / kInstants - mean_nm * mean_nm);
  const double hold_nm = s.parameters.axis.hold_jitter_nm;
  const double sample_nm2 =
      p.vibration_nm * p.vibration_nm + hold_nm * hold_nm + p.resolution_nm * p.resolution_nm / 12;
  const double independent = std::min<double>(samples, 1 + length_s / (2 * p.vibration_s));
  reading.mean_nm = first_nm + mean_nm +
                    std::sqrt(sample_nm2 / independent) * s.length_noise.gaussian() +
                    burst_nm * s.length_noise.gaussian();
  reading.std_nm = std::sqrt(sample_nm2 + spread_nm2 + 9 * burst_nm * burst_nm);

  const double end_s = s.seconds(reading.end);
  const double sampled_s = std::floor(end_s / p.air_probe_period_s) * p.air_probe_period_s;
  Random air_noise(mixed(s.seed ^ static_cast<std::uint64_t>(std::llround(sampled_s * 1e3))),
                   "interferometer.air");
  const double air_degc =
      s.world.at(sampled_s).air_probe_degc + p.air_probe_noise_k * air_noise.gaussian();
  reading.air_degc = std::round(air_degc / p.air_probe_resolution_k) * p.air_probe_resolution_k;
  reading.air_age_s = end_s - sampled_s;
  reading.level_pct = s.beam_broken ? 0 : p.level_pct;
  reading.beam_broken = s.beam_broken;
  reading.laser_stable = s.laser_stable;
  if (s.log) s.log->append("length", truth((reading.start + reading.end) / 2));
  return reading;
}

double LinearAxisPlant::sample_rate_hz() const {
  return state_->parameters.interferometer.sample_rate_hz;
}

void LinearAxisPlant::zero_length(int index, TimeNs now) {
  check(index == 0, "interferometer: this plant has one, index 0");
  advance_to(now);
  State& s = *state_;
  const auto at = s.instant(s.now_s());
  const auto& p = s.parameters.interferometer;
  constexpr double kZeroing_s = 0.1;  // the electronics averages that long
  const double noise_nm =
      p.vibration_nm / std::sqrt(1 + kZeroing_s / (2 * p.vibration_s)) * s.length_noise.gaussian();
  s.interferometer.zero(at.interferometer_true_nm, at.frame, noise_nm);
  s.true_at_zero_nm = at.interferometer_true_nm;
  s.beam_broken = false;
  if (s.log) s.log->append("zero", truth(s.now));
}

void LinearAxisPlant::set_dead_path_mm(int index, double mm) {
  check(index == 0, "interferometer: this plant has one, index 0");
  state_->interferometer.set_dead_path_mm(mm);
}

double LinearAxisPlant::probe_ohm(int input, TimeNs now) {
  advance_to(now);
  State& s = *state_;
  std::size_t i = 0;
  const auto* probe = s.probe(input, i);
  if (probe == nullptr || s.open_probes.contains(input)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double time_s = s.now_s();
  double degc = s.world.at(time_s).probe_degc[i];
  degc += s.disturbed(DisturbancePlace::probe_k, {.time_s = time_s, .input = input});
  const double ohm = probe->r0_ohm * (1 + degc * (probe->a_per_k + degc * probe->b_per_k2)) +
                     s.parameters.scanner_noise_ohm * s.scanner_noise.gaussian();
  const double grain_ohm = s.parameters.scanner_resolution_ohm;
  return std::round(ohm / grain_ohm) * grain_ohm;
}

bool LinearAxisPlant::has_probe(int input) const {
  std::size_t unused = 0;
  return state_->probe(input, unused) != nullptr;
}

StabiliserState LinearAxisPlant::stabiliser(int index, TimeNs now) {
  check(index == 0, "stabiliser: this plant has one, index 0");
  advance_to(now);
  return state_->world.stabiliser().state();
}

void LinearAxisPlant::set_set_point_degc(int index, double degc, TimeNs now) {
  check(index == 0, "stabiliser: this plant has one, index 0");
  advance_to(now);
  state_->world.stabiliser().set_set_point_degc(degc);
}

void LinearAxisPlant::set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct,
                                          TimeNs now) {
  check(index == 0, "stabiliser: this plant has one, index 0");
  advance_to(now);
  state_->world.stabiliser().set_mode(mode, manual_pct);
}

void LinearAxisPlant::set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k,
                                            double ti_s, double td_s, TimeNs now) {
  check(index == 0 && heat_band_k > 0 && cool_band_k > 0, "stabiliser 0 wants bands above 0");
  advance_to(now);
  state_->world.stabiliser().set_tuning(heat_band_k, cool_band_k, ti_s, td_s);
}

void LinearAxisPlant::break_beam(TimeNs now) {
  advance_to(now);
  state_->beam_broken = true;
}

void LinearAxisPlant::set_laser_stable(bool stable, TimeNs now) {
  advance_to(now);
  state_->laser_stable = stable;
}

void LinearAxisPlant::set_probe_open(int input, bool open, TimeNs now) {
  advance_to(now);
  if (open) {
    state_->open_probes.insert(input);
  } else {
    state_->open_probes.erase(input);
  }
}

void LinearAxisPlant::set_stabiliser_sensor_open(bool open, TimeNs now) {
  advance_to(now);
  state_->world.stabiliser().set_sensor_open(open);
}

void LinearAxisPlant::add_disturbance(DisturbancePlace place, Disturbance disturbance) {
  state_->disturbances.emplace(place, std::move(disturbance));
}

Truth LinearAxisPlant::truth(TimeNs at) {
  State& s = *state_;
  const auto i = s.instant(s.seconds(at));
  Truth truth{
      .time = at,
      .commanded_nm = s.axis.commanded_mm() * kNmPerMm,
      .q_scale_nm = i.servo.counter_mm * kNmPerMm,
      .end_effector_nm = i.loop.end_effector_nm(),
      .interferometer_true_nm = i.interferometer_true_nm,
      .robot_drift_nm = i.loop.robot_drift_nm,
      .device_drift_nm = i.loop.device_drift_nm,
      .air_error_nm = i.shown_nm - (i.interferometer_true_nm - s.true_at_zero_nm),
      .geometry_nm = i.loop.geometry_nm,
      .air_degc = i.frame.degc[static_cast<std::size_t>(s.parameters.interferometer.air_part)],
      .room_degc = i.frame.weather.room_degc,
      .pressure_hpa = i.frame.weather.pressure_hpa};
  truth.node_degc.assign(i.frame.degc.begin(),
                         i.frame.degc.begin() + static_cast<long>(s.node_names.size()));
  return truth;
}

std::span<const std::string> LinearAxisPlant::node_names() const { return state_->node_names; }

const PlantParameters& LinearAxisPlant::parameters() const { return state_->parameters; }

void LinearAxisPlant::attach_truth_log(std::unique_ptr<TruthLog> log) {
  state_->log = std::move(log);
  state_->next_tick_s = std::ceil(state_->now_s() / kTick_s) * kTick_s;
}

}  // namespace driftwise::simulated
