#include "drivers/simulated/plant/cell/cell_plant.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kTick_s = 10;  // rows of the truth log without an occasion

std::size_t place(int index) { return static_cast<std::size_t>(index); }

}  // namespace

// A bug of the caller, not of the world.
void CellPlant::check(bool good, const char* what) {
  if (!good) throw std::out_of_range(what);
}

CellPlant::CellPlant(std::shared_ptr<const CellParameters> parameters, std::uint64_t seed,
                     TimeNs epoch)
    : cell_(std::move(parameters)),
      seed_(seed),
      epoch_(epoch),
      now_(epoch),
      world_(*cell_, seed),
      scanner_noise_(seed, "scanner"),
      voltages_(cell_->voltages, seed),
      probe_faults_(cell_->hidden) {
  const Weather typed_in = world_.at(0).weather;
  for (int i = 0; i < static_cast<int>(cell_->axes.size()); ++i) {
    axes_.emplace_back(cell_->axes[place(i)], seed, i);
    scale_noise_.emplace_back(seed, stream_of("axis.scale", i));
  }
  for (int i = 0; i < static_cast<int>(cell_->interferometers.size()); ++i) {
    interferometers_.emplace_back(cell_->interferometers[place(i)], typed_in, place(i));
    length_noise_.emplace_back(seed, stream_of("interferometer.reading", i));
  }
  true_at_zero_nm_.assign(interferometers_.size(), 0.0);
  hidden_at_zero_nm_.assign(interferometers_.size(), 0.0);
  beam_broken_.assign(interferometers_.size(), false);
  for (const auto& part : cell_->parts) node_names_.push_back(part.name);
}

void CellPlant::zero_at_start() {
  for (int i = 0; i < interferometer_count(); ++i) {
    const Beam start = beam(i, 0);
    interferometers_[place(i)].zero(start.true_nm, start.frame, 0);
    true_at_zero_nm_[place(i)] = start.true_nm;
    hidden_at_zero_nm_[place(i)] = start.hidden_nm;
  }
}

void CellPlant::log(const char* kind, TimeNs at) {
  if (log_) log_->append(kind, at, truth_values(at));
}

void CellPlant::advance_to(TimeNs now) {
  if (now <= now_) return;
  const SlowWorld::Motors motors{
      .motor_w = [this](std::size_t axis, double time_s) { return axes_[axis].motor_w(time_s); },
      .scale_mm = [this](std::size_t axis, double time_s,
                         double wander_nm) { return axes_[axis].at(time_s, wander_nm).scale_mm; }};
  // Ticks at their own times, so that their rows do not depend on who asks when.
  while (log_ && next_tick_s_ <= seconds(now)) {
    world_.advance_to(next_tick_s_, motors);
    log("tick", epoch_ + static_cast<TimeNs>(std::llround(next_tick_s_ * 1e9)));
    next_tick_s_ += kTick_s;
  }
  now_ = now;
  world_.advance_to(now_s(), motors);
  if (voltages_.sees_motors()) follow_motors();
}

double CellPlant::scale_mm(int axis, double time_s) const {
  return axes_[place(axis)].at(time_s, 0).scale_mm;
}

// In steps within which no motion of an axis turns round unseen.
void CellPlant::follow_motors() {
  constexpr double kStep_s = 0.02, kLookBack_s = 100;
  followed_s_ = std::max(followed_s_, now_s() - kLookBack_s);
  for (; followed_s_ < now_s(); followed_s_ = std::min(followed_s_ + kStep_s, now_s())) {
    voltages_.follow([this](int axis) { return scale_mm(axis, followed_s_); });
  }
}

double CellPlant::disturbed(DisturbancePlace where, const DisturbanceContext& context) const {
  double sum = 0;
  const auto [first, last] = disturbances_.equal_range(where);
  for (auto it = first; it != last; ++it) sum += it->second(context);
  return sum;
}

const AxisParameters& CellPlant::axis_parameters(int index) const {
  check(index >= 0 && index < axis_count(), "axis: this plant has no such axis");
  return cell_->axes[place(index)];
}

AxisState CellPlant::axis(int index, TimeNs now) {
  const auto& p = axis_parameters(index);
  advance_to(now);
  AxisState state = axes_[place(index)].state(now_s());
  const double wander_nm = world_.at(now_s()).hold_wander_nm[place(index)];
  const auto position = axes_[place(index)].at(now_s(), wander_nm);
  const double jitter_nm =
      std::hypot(p.scale_noise_nm, p.hold_jitter_nm) * scale_noise_[place(index)].gaussian();
  const double grain_mm = p.scale_resolution_nm / kNmPerMm;
  state.q_mm = std::round((position.counter_mm + jitter_nm / kNmPerMm) / grain_mm) * grain_mm;
  return state;
}

AxisTravel CellPlant::axis_travel(int index) const {
  const auto& axis = axis_parameters(index);
  return {axis.min_mm, axis.max_mm};
}

void CellPlant::start_move(int index, double target_mm, TimeNs now) {
  axis_parameters(index);
  advance_to(now);
  before_command();
  axes_[place(index)].start_move(target_mm, now_s());
}

void CellPlant::set_velocity(int index, double mm_per_s, TimeNs now) {
  axis_parameters(index);
  check(mm_per_s > 0, "an axis wants a velocity above 0");
  advance_to(now);
  axes_[place(index)].set_velocity(mm_per_s);
}

void CellPlant::set_servo(int index, bool on, TimeNs now) {
  axis_parameters(index);
  advance_to(now);
  before_command();
  axes_[place(index)].set_servo(on, now_s());
}

void CellPlant::start_reference(int index, TimeNs now) {
  axis_parameters(index);
  advance_to(now);
  before_command();
  axes_[place(index)].start_reference(now_s());
  log("reference", now_);
}

void CellPlant::halt_axis(int index, TimeNs now) {
  axis_parameters(index);
  advance_to(now);
  before_command();
  axes_[place(index)].halt(now_s());
}

double CellPlant::shown_nm(int index, const Beam& beam) const {
  return interferometers_[place(index)].shown_nm(beam.true_nm, beam.frame) + beam.disturbed_nm +
         (beam.hidden_nm - hidden_at_zero_nm_[place(index)]);
}

double CellPlant::hidden_stage_nm(int axis, const Frame& frame, HiddenContext at) const {
  double sum_nm = 0;
  const auto& all = world_.hidden();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].place != HiddenPlace::stage_nm || all[i].index != axis) continue;
    sum_nm += all[i].mechanism->value_nm(at, frame.hidden[i]);
  }
  return sum_nm;
}

double CellPlant::hidden_beam_nm(int beam, const Frame& frame, double time_s,
                                 double true_nm) const {
  double sum_nm = 0;
  const auto& p = cell_->interferometers[place(beam)];
  const HiddenContext at{.time_s = time_s, .path_mm = p.dead_path_mm + true_nm / kNmPerMm};
  const auto& all = world_.hidden();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].place != HiddenPlace::beam_nm || all[i].index != beam) continue;
    sum_nm += p.sign * all[i].mechanism->value_nm(at, frame.hidden[i]);
  }
  return sum_nm;
}

std::vector<std::string> CellPlant::pose_columns(std::initializer_list<const char*> own) const {
  std::vector<std::string> columns{"q1_commanded_nm",
                                   "q2_commanded_nm",
                                   "q3_commanded_nm",
                                   "q1_scale_nm",
                                   "q2_scale_nm",
                                   "q3_scale_nm",
                                   "x_nm",
                                   "y_nm",
                                   "z_nm",
                                   "rx_arcsec",
                                   "ry_arcsec",
                                   "rz_arcsec"};
  columns.insert(columns.end(), own.begin(), own.end());
  for (const auto& name : node_names()) columns.push_back(name + "_degC");
  add_hidden_columns(columns);
  return columns;
}

void CellPlant::add_hidden_columns(std::vector<std::string>& columns) const {
  for (const auto& one : world_.hidden()) columns.push_back("hidden_" + one.name + "_nm");
}

void CellPlant::add_hidden_values(const Frame& frame, double time_s,
                                  std::vector<double>& values) const {
  const auto& all = world_.hidden();
  for (std::size_t i = 0; i < all.size(); ++i) {
    HiddenContext at{.time_s = time_s};
    if (all[i].place == HiddenPlace::stage_nm) {
      at.stage_mm =
          axes_[place(all[i].index)].at(time_s, frame.hold_wander_nm[place(all[i].index)]).scale_mm;
      at.force_n = hidden_force_n(time_s);
    } else {
      at.path_mm = cell_->interferometers[place(all[i].index)].dead_path_mm;
    }
    values.push_back(all[i].mechanism->value_nm(at, frame.hidden[i]));
  }
}

double CellPlant::air_probe_degc(int index, double sampled_s) const {
  const auto& p = cell_->interferometers[place(index)];
  Random noise(mixed(seed_ ^ static_cast<std::uint64_t>(std::llround(sampled_s * 1e3))),
               stream_of("interferometer.air", index));
  const double degc = world_.at(sampled_s).beams[place(index)].air_probe_degc +
                      p.air_probe_noise_k * noise.gaussian();
  return std::round(degc / p.air_probe_resolution_k) * p.air_probe_resolution_k;
}

LengthReading CellPlant::measure_length(int index, TimeNs start, int samples) {
  check(index >= 0 && index < interferometer_count() && samples > 0,
        "interferometer: no such one, or no samples");
  const auto& p = cell_->interferometers[place(index)];
  const double length_s = samples / p.sample_rate_hz;
  LengthReading reading{.start = start,
                        .end = start + static_cast<TimeNs>(std::llround(length_s * 1e9))};
  advance_to(reading.end);

  // What changes during the reading is seen at some instants; what is faster is noise of the
  // samples.
  double sum_nm = 0, square_nm2 = 0, burst_nm = 0, first_nm = 0;
  for (int k = 0; k < instants_per_reading_; ++k) {
    const Beam at = beam(index, seconds(start) + (k + 0.5) / instants_per_reading_ * length_s);
    const double shown = shown_nm(index, at);
    if (k == 0) first_nm = shown;
    sum_nm += shown - first_nm;
    square_nm2 += (shown - first_nm) * (shown - first_nm);
    burst_nm = std::max(burst_nm, at.frame.burst_nm);
    if (at.lost) beam_broken_[place(index)] = true;
  }
  const double mean_nm = sum_nm / instants_per_reading_;
  const double spread_nm2 = std::max(0.0, square_nm2 / instants_per_reading_ - mean_nm * mean_nm);
  const double hold_nm = cell_->axes.front().hold_jitter_nm;
  const double sample_nm2 =
      p.vibration_nm * p.vibration_nm + hold_nm * hold_nm + p.resolution_nm * p.resolution_nm / 12;
  const double independent = std::min<double>(samples, 1 + length_s / (2 * p.vibration_s));
  Random& noise = length_noise_[place(index)];
  reading.mean_nm = first_nm + mean_nm + std::sqrt(sample_nm2 / independent) * noise.gaussian() +
                    burst_nm * noise.gaussian();
  reading.std_nm = std::sqrt(sample_nm2 + spread_nm2 + 9 * burst_nm * burst_nm);

  const double end_s = seconds(reading.end);
  const double sampled_s = std::floor(end_s / p.air_probe_period_s) * p.air_probe_period_s;
  const bool broken = beam_broken_[place(index)];
  reading.air_degc = air_probe_degc(index, sampled_s);
  reading.air_age_s = end_s - sampled_s;
  reading.level_pct = broken ? 0 : p.level_pct;
  reading.beam_broken = broken;
  reading.laser_stable = laser_stable_;
  log("length", (reading.start + reading.end) / 2);
  return reading;
}

double CellPlant::sample_rate_hz() const { return cell_->interferometers.front().sample_rate_hz; }

void CellPlant::zero_length(int index, TimeNs now) {
  check(index >= 0 && index < interferometer_count(), "interferometer: no such one");
  advance_to(now);
  const Beam at = beam(index, now_s());
  const auto& p = cell_->interferometers[place(index)];
  constexpr double kZeroing_s = 0.1;  // the electronics averages that long
  const double noise_nm = p.vibration_nm / std::sqrt(1 + kZeroing_s / (2 * p.vibration_s)) *
                          length_noise_[place(index)].gaussian();
  interferometers_[place(index)].zero(at.true_nm, at.frame, noise_nm);
  true_at_zero_nm_[place(index)] = at.true_nm;
  hidden_at_zero_nm_[place(index)] = at.hidden_nm;
  beam_broken_[place(index)] = at.lost;
  log("zero", now_);
}

void CellPlant::set_dead_path_mm(int index, double mm) {
  check(index >= 0 && index < interferometer_count(), "interferometer: no such one");
  interferometers_[place(index)].set_dead_path_mm(mm);
}

const ThermometerParameters* CellPlant::probe(int input, std::size_t& index) const {
  for (index = 0; index < cell_->thermometers.size(); ++index) {
    if (cell_->thermometers[index].input == input) return &cell_->thermometers[index];
  }
  return nullptr;
}

double CellPlant::probe_ohm(int input, TimeNs now) {
  advance_to(now);
  std::size_t i = 0;
  const auto* found = probe(input, i);
  if (found == nullptr || open_probes_.contains(input)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const int connected = probe_faults_.connected(input, now_s());
  if (connected != input) found = probe(connected, i);
  double degc = world_.at(now_s()).probe_degc[i];
  degc += disturbed(DisturbancePlace::probe_k, {.time_s = now_s(), .input = input});
  double ohm = found->r0_ohm * (1 + degc * (found->a_per_k + degc * found->b_per_k2)) +
               cell_->scanner_noise_ohm * scanner_noise_.gaussian();
  ohm = probe_faults_.shown_ohm(input, now_s(), ohm, found->r0_ohm);
  const double grain_ohm = cell_->scanner_resolution_ohm;
  return std::round(ohm / grain_ohm) * grain_ohm;
}

double CellPlant::input_volt(int input, TimeNs now) {
  advance_to(now);
  if (open_probes_.contains(input)) return 0;  // nothing drives the wires
  if (truth_places_.empty()) {
    const auto columns = truth_columns();
    for (std::size_t i = 0; i < columns.size(); ++i) truth_places_[columns[i]] = i;
  }
  const auto values = truth_values(now_);
  return voltages_.volt(
      input, [&](const std::string& column) { return values[truth_places_.at(column)]; },
      [this](int axis) { return scale_mm(axis, now_s()); });
}

void CellPlant::set_input_volt(int input, std::optional<double> volt, TimeNs now) {
  advance_to(now);
  voltages_.force(input, volt);
}

bool CellPlant::has_probe(int input) const {
  std::size_t unused = 0;
  return probe(input, unused) != nullptr;
}

StabiliserState CellPlant::stabiliser(int index, TimeNs now) {
  check(index >= 0 && index < stabiliser_count(), "stabiliser: no such one");
  advance_to(now);
  return world_.stabiliser(place(index)).state();
}

void CellPlant::set_set_point_degc(int index, double degc, TimeNs now) {
  check(index >= 0 && index < stabiliser_count(), "stabiliser: no such one");
  advance_to(now);
  world_.stabiliser(place(index)).set_set_point_degc(degc);
}

void CellPlant::set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct, TimeNs now) {
  check(index >= 0 && index < stabiliser_count(), "stabiliser: no such one");
  advance_to(now);
  world_.stabiliser(place(index)).set_mode(mode, manual_pct);
}

void CellPlant::set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k,
                                      double ti_s, double td_s, TimeNs now) {
  check(index >= 0 && index < stabiliser_count() && heat_band_k > 0 && cool_band_k > 0,
        "stabiliser: no such one, or a band that is not above 0");
  advance_to(now);
  world_.stabiliser(place(index)).set_tuning(heat_band_k, cool_band_k, ti_s, td_s);
}

void CellPlant::break_beam(TimeNs now, int index) {
  check(index >= 0 && index < interferometer_count(), "interferometer: no such one");
  advance_to(now);
  beam_broken_[place(index)] = true;
}

bool CellPlant::open_box(double for_s, TimeNs now) {
  if (cell_->box_air_part == kRoom) return false;
  advance_to(now);
  world_.open_box_until(now_s() + for_s);
  return true;
}

void CellPlant::set_laser_stable(bool stable, TimeNs now) {
  advance_to(now);
  laser_stable_ = stable;
}

void CellPlant::set_probe_open(int input, bool open, TimeNs now) {
  advance_to(now);
  if (open) {
    open_probes_.insert(input);
  } else {
    open_probes_.erase(input);
  }
}

void CellPlant::set_stabiliser_sensor_open(bool open, TimeNs now, int index) {
  check(index >= 0 && index < stabiliser_count(), "stabiliser: no such one");
  advance_to(now);
  world_.stabiliser(place(index)).set_sensor_open(open);
}

void CellPlant::add_disturbance(DisturbancePlace place, Disturbance disturbance) {
  before_command();
  disturbances_.emplace(place, std::move(disturbance));
}

void CellPlant::attach_truth_log(std::unique_ptr<TruthLog> log) {
  log_ = std::move(log);
  next_tick_s_ = std::ceil(now_s() / kTick_s) * kTick_s;
}

}  // namespace driftwise::simulated
