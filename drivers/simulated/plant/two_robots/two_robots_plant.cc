#include "drivers/simulated/plant/two_robots/two_robots_plant.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kStep_s = 0.1;          // of everything that contact remembers
constexpr double kKept_s = 300;          // of the past, for readings that look back
constexpr double kSameCrater_mm = 5e-3;  // a tip that comes back so near meets its own crater
constexpr double kFar_nm = 20e3;         // beyond it, at rest, a look per second is enough
constexpr double kLook_s = 1, kMoving_s = 3;
constexpr int kLowerInput = 100;  // inputs of the lower robot's scanner, shifted
constexpr double kRadOfDegree = std::numbers::pi / 180;
constexpr double kUmPerMm = 1e3;

// The upper robot's room is the lower one's.
TwoRobotsParameters in_one_room(TwoRobotsParameters parameters) {
  parameters.lower.room = parameters.upper.room;
  parameters.lower.start_hours_before = parameters.upper.start_hours_before;
  return parameters;
}

}  // namespace

TwoRobotsPlant::TwoRobotsPlant(TwoRobotsParameters parameters, std::uint64_t seed, TimeNs epoch)
    : MicroNanoPlant(parameters.upper, seed, epoch),
      parameters_(in_one_room(std::move(parameters))),
      lower_(parameters_.lower, seed, epoch),
      servo_(parameters_.holding) {
  const auto& c = parameters_.contact;
  Random drawn(seed, "contact.drawn");
  gap_mm_ = c.gap_mm + drawn.uniform(-c.gap_spread_mm, c.gap_spread_mm);
  lever_mm_ = c.lever_mm + drawn.uniform(-c.lever_spread_mm, c.lever_spread_mm);
  tilt_rx_rad_ = kRadOfDegree * drawn.uniform(-c.parallelism_deg, c.parallelism_deg);
  tilt_ry_rad_ = kRadOfDegree * drawn.uniform(-c.parallelism_deg, c.parallelism_deg);
  pushes_.push_back({.time_s = -1e9});
  for (int i = 0; i < kUpperAxes; ++i)
    axes_[static_cast<std::size_t>(i)].set_push([this](double time_s) { return push_nm(time_s); });
}

double TwoRobotsPlant::substrate_rx_arcsec() const { return tilt_rx_rad_ / kRadPerArcsec; }
double TwoRobotsPlant::substrate_ry_arcsec() const { return tilt_ry_rad_ / kRadPerArcsec; }

bool TwoRobotsPlant::is_lower_axis(int index) const { return index >= kUpperAxes; }

double TwoRobotsPlant::held_nm(double time_s) const {
  for (auto push = pushes_.rbegin(); push != pushes_.rend(); ++push)
    if (push->time_s <= time_s) return push->push_nm;
  return pushes_.front().push_nm;
}

double TwoRobotsPlant::push_nm(double time_s) const {
  double sum_nm = held_nm(time_s);
  const auto& k = parameters_.knock;
  for (const Knock& knock : knocks_) {
    const double since_s = time_s - knock.time_s;
    if (since_s < 0) continue;
    sum_nm += knock.amplitude_nm * std::exp(-since_s / k.decay_s) *
              std::cos(2 * std::numbers::pi * k.hz * since_s);
  }
  return sum_nm;
}

// The tool is rigid: its tip hangs the lever below the cube's centre and turns with it. The
// substrate's surface goes through the lower robot's centre of rotation.
TwoRobotsPlant::Place TwoRobotsPlant::place(double time_s) const {
  const CubePose cube = cube_pose(time_s);
  const MinAnglePose below = lower_.pose(time_s);
  const Vec3 hanging{0, 0, -lever_mm_};
  const Vec3 swung = rotation_by(cube.turn_rad) * hanging - hanging;
  Place out;
  out.tip_mm = cube.centre_mm + swung;
  out.rx_rad = below.rx_rad + tilt_rx_rad_;
  out.ry_rad = below.ry_rad + tilt_ry_rad_;
  const double dx = out.tip_mm.x - below.position_mm[0], dy = out.tip_mm.y - below.position_mm[1];
  const double surface_mm =
      below.position_mm[2] + dy * std::tan(out.rx_rad) - dx * std::tan(out.ry_rad);
  out.sub_x_mm = dx / std::cos(out.ry_rad);
  out.sub_y_mm = dy / std::cos(out.rx_rad);
  const double above_mm =
      gap_mm_ + spacers_mm_ + (out.tip_mm.z - parameters_.contact.tip_at_mm) - surface_mm;
  out.gap_nm = above_mm * kNmPerMm - held_nm(time_s);  // push carries the tip up by as much
  return out;
}

Crater& TwoRobotsPlant::crater_at(const Place& at) {
  for (auto crater = craters_.rbegin(); crater != craters_.rend(); ++crater)
    if (std::hypot(crater->x_mm - at.sub_x_mm, crater->y_mm - at.sub_y_mm) < kSameCrater_mm)
      return *crater;
  craters_.push_back({.x_mm = at.sub_x_mm, .y_mm = at.sub_y_mm});
  return craters_.back();
}

void TwoRobotsPlant::step(double time_s) {
  const bool commanded = time_s - last_command_s_ < kMoving_s;
  if (!commanded && !touching_ && gap_nm_ > kFar_nm && time_s - last_looked_s_ < kLook_s) return;
  last_looked_s_ = time_s;
  const Place at = place(time_s);
  gap_nm_ = at.gap_nm;
  Crater nothing;
  Balance now{.push_nm = servo_.push_nm(0)};
  if (at.gap_nm < -now.push_nm)
    now = balance(-at.gap_nm, parameters_.contact, servo_, crater_at(at));
  touching_ = now.force_n > 0 || std::abs(now.push_nm) > 1;
  servo_.integrate(now.push_nm, kStep_s);
  if (now.push_nm == pushes_.back().push_nm && now.force_n == pushes_.back().force_n) return;
  pushes_.push_back({.time_s = time_s, .push_nm = now.push_nm, .force_n = now.force_n});
  while (pushes_.size() > 2 && pushes_[1].time_s < time_s - kKept_s) pushes_.pop_front();
  forget_instants();
}

void TwoRobotsPlant::advance_to(TimeNs now) {
  for (; next_step_s_ <= seconds(now); next_step_s_ += kStep_s) {
    const TimeNs at = epoch_ + static_cast<TimeNs>(std::llround(next_step_s_ * 1e9));
    lower_.advance_to(at);
    CellPlant::advance_to(at);
    step(next_step_s_);
  }
  lower_.advance_to(now);
  CellPlant::advance_to(now);
}

AxisState TwoRobotsPlant::axis(int index, TimeNs now) {
  if (!is_lower_axis(index)) return CellPlant::axis(index, now);
  advance_to(now);
  return lower_.axis(index - kUpperAxes, now);
}

AxisTravel TwoRobotsPlant::axis_travel(int index) const {
  return is_lower_axis(index) ? lower_.axis_travel(index - kUpperAxes)
                              : CellPlant::axis_travel(index);
}

void TwoRobotsPlant::start_move(int index, double target_mm, TimeNs now) {
  advance_to(now);
  last_command_s_ = now_s();
  if (is_lower_axis(index)) return lower_.start_move(index - kUpperAxes, target_mm, now);
  CellPlant::start_move(index, target_mm, now);
}

void TwoRobotsPlant::set_velocity(int index, double mm_per_s, TimeNs now) {
  if (is_lower_axis(index)) return lower_.set_velocity(index - kUpperAxes, mm_per_s, now);
  CellPlant::set_velocity(index, mm_per_s, now);
}

void TwoRobotsPlant::set_servo(int index, bool on, TimeNs now) {
  advance_to(now);
  last_command_s_ = now_s();
  if (is_lower_axis(index)) return lower_.set_servo(index - kUpperAxes, on, now);
  CellPlant::set_servo(index, on, now);
}

void TwoRobotsPlant::start_reference(int index, TimeNs now) {
  advance_to(now);
  last_command_s_ = now_s() + 10;  // searching takes its time
  if (is_lower_axis(index)) return lower_.start_reference(index - kUpperAxes, now);
  CellPlant::start_reference(index, now);
}

void TwoRobotsPlant::halt_axis(int index, TimeNs now) {
  advance_to(now);
  if (is_lower_axis(index)) return lower_.halt_axis(index - kUpperAxes, now);
  CellPlant::halt_axis(index, now);
}

LengthReading TwoRobotsPlant::measure_length(int index, TimeNs start, int samples) {
  if (index < kUpperLengths) return CellPlant::measure_length(index, start, samples);
  const auto reading = lower_.measure_length(index - kUpperLengths, start, samples);
  advance_to(reading.end);
  return reading;
}

void TwoRobotsPlant::zero_length(int index, TimeNs now) {
  advance_to(now);
  if (index < kUpperLengths) return CellPlant::zero_length(index, now);
  lower_.zero_length(index - kUpperLengths, now);
}

void TwoRobotsPlant::set_dead_path_mm(int index, double mm) {
  if (index < kUpperLengths) return CellPlant::set_dead_path_mm(index, mm);
  lower_.set_dead_path_mm(index - kUpperLengths, mm);
}

void TwoRobotsPlant::break_beam(TimeNs now, int index) {
  advance_to(now);
  if (index < kUpperLengths) return CellPlant::break_beam(now, index);
  lower_.break_beam(now, index - kUpperLengths);
}

AngleReading TwoRobotsPlant::measure_angle(int index, double average_s, TimeNs end) {
  if (index < kUpperAngles) return MicroNanoPlant::measure_angle(index, average_s, end);
  advance_to(end);
  return lower_.measure_angle(index - kUpperAngles, average_s, end);
}

double TwoRobotsPlant::probe_ohm(int input, TimeNs now) {
  if (CellPlant::has_probe(input)) return CellPlant::probe_ohm(input, now);
  advance_to(now);
  return lower_.probe_ohm(input - kLowerInput, now);
}

bool TwoRobotsPlant::has_probe(int input) const {
  return CellPlant::has_probe(input) || lower_.has_probe(input - kLowerInput);
}

void TwoRobotsPlant::knock(double amplitude_nm, TimeNs now) {
  advance_to(now);
  std::erase_if(knocks_, [this](const Knock& knock) { return knock.time_s < now_s() - kKept_s; });
  knocks_.push_back({.time_s = now_s(), .amplitude_nm = amplitude_nm});
  forget_instants();
}

void TwoRobotsPlant::set_spacers_mm(double height_mm, TimeNs now) {
  check(height_mm >= 0, "spacers: expected a height of 0 and more");
  advance_to(now);
  spacers_mm_ = height_mm;
  gap_nm_ = place(now_s()).gap_nm;
  forget_instants();
}

void TwoRobotsPlant::set_substrate_arcsec(double rx_arcsec, double ry_arcsec, TimeNs now) {
  advance_to(now);
  tilt_rx_rad_ = rx_arcsec * kRadPerArcsec;
  tilt_ry_rad_ = ry_arcsec * kRadPerArcsec;
  craters_.clear();
  gap_nm_ = place(now_s()).gap_nm;
  forget_instants();
}

std::vector<MicroscopeRow> TwoRobotsPlant::microscope(int origin) const {
  check(origin >= 1 && static_cast<std::size_t>(origin) <= craters_.size(),
        "microscope: there is no such indent");
  const auto& m = parameters_.microscope;
  const Crater& from = craters_[static_cast<std::size_t>(origin - 1)];
  std::vector<MicroscopeRow> rows;
  for (std::size_t i = 0; i < craters_.size(); ++i) {
    const int id = static_cast<int>(i) + 1;
    const double x_um = (craters_[i].x_mm - from.x_mm) * kUmPerMm;
    const double y_um = (craters_[i].y_mm - from.y_mm) * kUmPerMm;
    const double way_um = std::hypot(x_um, y_um);
    const bool fine = way_um <= m.fine_um;
    MicroscopeRow row{.id = id,
                      .diagonal_um = diagonal_um(craters_[i]),
                      .pixel_nm = fine ? m.fine_pixel_nm : m.coarse_pixel_nm,
                      .marking_px = fine ? m.fine_marking_px : m.coarse_marking_px};
    if (!fine)
      row.pictures_joined = std::max(0, static_cast<int>(std::ceil(way_um / m.picture_um)) - 1);
    Random marked(seed_, "microscope." + std::to_string(origin) + "." + std::to_string(id));
    const double pixel_um = row.pixel_nm / kUmPerMm;
    const auto shown_um = [&](double um, double ppm) {
      if (id == origin) return 0.0;
      double error_px = 0;
      for (int end = 0; end < 2; ++end) error_px += marked.uniform(-row.marking_px, row.marking_px);
      for (int k = 0; k < row.pictures_joined; ++k) error_px += marked.uniform(-0.5, 0.5);
      return um * (1 + ppm * 1e-6) + error_px * pixel_um;
    };
    row.x_um = shown_um(x_um, m.scale_x_ppm);
    row.y_um = shown_um(y_um, m.scale_y_ppm);
    rows.push_back(row);
  }
  return rows;
}

ContactTruth TwoRobotsPlant::contact(TimeNs at) {
  advance_to(at);
  const Place here = place(seconds(at));
  return {.gap_nm = here.gap_nm,
          .push_nm = pushes_.back().push_nm,
          .force_n = pushes_.back().force_n,
          .tip_mm = to_array(here.tip_mm),
          .rx_arcsec = here.rx_rad / kRadPerArcsec,
          .ry_arcsec = here.ry_rad / kRadPerArcsec};
}

std::vector<std::string> TwoRobotsPlant::truth_columns() const {
  auto columns = MicroNanoPlant::truth_columns();
  for (const char* more : {"tip_x_nm", "tip_y_nm", "gap_nm", "push_nm", "contact_N",
                           "substrate_rx_arcsec", "substrate_ry_arcsec", "ma_x_nm", "ma_y_nm",
                           "ma_z_nm", "ma_rx_arcsec", "ma_ry_arcsec", "lever_mm"})
    columns.emplace_back(more);
  return columns;
}

std::vector<double> TwoRobotsPlant::truth_values(TimeNs at) {
  auto values = MicroNanoPlant::truth_values(at);
  const Place here = place(seconds(at));
  const MinAnglePose below = lower_.pose(seconds(at));
  for (const double value :
       {here.tip_mm.x * kNmPerMm, here.tip_mm.y * kNmPerMm, here.gap_nm, pushes_.back().push_nm,
        pushes_.back().force_n, here.rx_rad / kRadPerArcsec, here.ry_rad / kRadPerArcsec,
        below.position_mm[0] * kNmPerMm, below.position_mm[1] * kNmPerMm,
        below.position_mm[2] * kNmPerMm, below.rx_rad / kRadPerArcsec, below.ry_rad / kRadPerArcsec,
        lever_mm_})
    values.push_back(value);
  return values;
}

}  // namespace driftwise::simulated
