#include "drivers/simulated/plant/min_angle/min_angle_plant.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulated/plant/micro_nano/micro_nano_mechanics.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kTipStep_s = 0.1;  // a motion takes a second and more
constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kMillimetresPerMicrometre = 1e-3;

// Three equations, by Cramer's rule.
Vec3 solved(Vec3 a, Vec3 b, Vec3 c, Vec3 right) {
  const double whole = dot(a, cross(b, c));
  return (1 / whole) *
         Vec3{dot(right, cross(b, c)), dot(a, cross(right, c)), dot(a, cross(b, right))};
}

}  // namespace

MinAnglePlant::MinAnglePlant(MinAngleParameters parameters, std::uint64_t seed, TimeNs epoch)
    : CellPlant(std::make_unique<const MinAngleParameters>(std::move(parameters)), seed, epoch),
      parameters_(static_cast<const MinAngleParameters&>(cell())),
      probe_noise_(seed, "touch_probe.reading") {
  for (int i = 0; i < collimator_count(); ++i)
    angle_noise_.emplace_back(seed, stream_of("collimator.reading", i));
  tip_mm_ = pose(0).position_mm[2];
  for (int i = 0; i < kTouchProbe; ++i) CellPlant::zero_length(i, epoch);
}

double MinAnglePlant::joint_height_mm(std::size_t screw, double time_s, const Frame& frame) const {
  const auto& p = parameters_.screws[screw];
  const double scale_mm = axes_[screw].at(time_s, frame.hold_wander_nm[screw]).scale_mm;
  double height_mm =
      scale_mm * (1 - p.scale_ppm * 1e-6) +
      growth_mm(parameters_.end_effector.height[screw], parameters_.reference_degc, frame.degc);
  if (!parameters_.hidden.empty())
    height_mm +=
        hidden_stage_nm(static_cast<int>(screw), frame, {.time_s = time_s, .stage_mm = scale_mm}) /
        kNmPerMm;
  return height_mm;
}

MinAnglePose MinAnglePlant::pose(double time_s) const { return pose(time_s, world_.at(time_s)); }

// The joints' heights fix z and both tilts; the three legs share what is left: each wants the
// end-effector where its own guide and its bent flexure put it.
MinAnglePose MinAnglePlant::pose(double time_s, const Frame& frame) const {
  const auto& e = parameters_.end_effector;
  Vec3 ones{1, 1, 1}, px, py, height;
  double x_mm = growth_mm(e.x, parameters_.reference_degc, frame.degc);
  double y_mm = growth_mm(e.y, parameters_.reference_degc, frame.degc);
  double turn_rad = 0;
  std::array<double, kScrews> joint_x{}, joint_y{}, joint_z{};
  for (std::size_t i = 0; i < kScrews; ++i) {
    const auto& screw = parameters_.screws[i];
    const double azimuth = screw.azimuth_deg * kRadPerDegree;
    const double out_x = std::cos(azimuth), out_y = std::sin(azimuth);
    joint_x[i] = screw.radius_mm * out_x;
    joint_y[i] = screw.radius_mm * out_y;
    const double h = joint_z[i] = joint_height_mm(i, time_s, frame);
    const double pulled_mm = e.shortening_factor * h * h / screw.leg_mm;
    const double dx = 1e-3 * screw.lean_mrad[0] * h - pulled_mm * out_x;
    const double dy = 1e-3 * screw.lean_mrad[1] * h - pulled_mm * out_y;
    x_mm += dx / kScrews;
    y_mm += dy / kScrews;
    turn_rad += (out_x * dy - out_y * dx) / (kScrews * screw.radius_mm);
  }
  px = {joint_x[0], joint_x[1], joint_x[2]};
  py = {joint_y[0], joint_y[1], joint_y[2]};
  height = {joint_z[0], joint_z[1], joint_z[2]};
  // height = z - sin(ry) px + cos(ry) sin(rx) py: the third row of Ry Rx.
  const Vec3 found = solved(ones, px, py, height);
  MinAnglePose pose;
  pose.position_mm = {x_mm, y_mm, found.x};
  pose.ry_rad = std::asin(-found.y);
  pose.rx_rad = std::asin(found.z / std::cos(pose.ry_rad));
  pose.rz_rad = turn_rad;
  return pose;
}

// The cube hangs below the end-effector and swings with its tilts.
Vec3 MinAnglePlant::cube_mm(const MinAnglePose& pose) const {
  const double below = parameters_.end_effector.cube_below_mm;
  const double cx = std::cos(pose.rx_rad), sx = std::sin(pose.rx_rad);
  const double cy = std::cos(pose.ry_rad), sy = std::sin(pose.ry_rad);
  return {pose.position_mm[0] - below * sy * cx, pose.position_mm[1] + below * sx,
          pose.position_mm[2] + below * (1 - cy * cx)};
}

void MinAnglePlant::advance_to(TimeNs now) {
  CellPlant::advance_to(now);
  const double half_mm = parameters_.probe.friction_um * kMillimetresPerMicrometre / 2;
  for (; next_tip_s_ <= now_s(); next_tip_s_ += kTipStep_s) {
    const double z_mm = pose(next_tip_s_).position_mm[2];
    tip_mm_ = std::clamp(tip_mm_, z_mm - half_mm, z_mm + half_mm);
  }
}

LengthReading MinAnglePlant::measure_length(int index, TimeNs start, int samples) {
  if (index != kTouchProbe) return CellPlant::measure_length(index, start, samples);
  const double length_s = samples / sample_rate_hz();
  LengthReading reading{.start = start,
                        .end = start + static_cast<TimeNs>(std::llround(length_s * 1e9))};
  advance_to(reading.end);
  const auto& p = parameters_.probe;
  const double half_mm = p.friction_um * kMillimetresPerMicrometre / 2;
  const double z_mm = pose(seconds(start) + length_s / 2).position_mm[2];
  const double tip_mm = std::clamp(tip_mm_, z_mm - half_mm, z_mm + half_mm);
  // A flat face that rises by dz pushes a leaning axis back by dz over the cosine.
  const double way_mm = tip_mm / std::cos(p.lean_deg * kRadPerDegree);
  reading.mean_nm = way_mm * kNmPerMm + p.noise_nm * probe_noise_.gaussian();
  reading.beam_broken = knocked_off_ || std::abs(way_mm) > p.range_mm;
  note("length");
  return reading;
}

void MinAnglePlant::zero_length(int index, TimeNs now) {
  check(index != kTouchProbe, "the touch probe has no zero to set");
  CellPlant::zero_length(index, now);
}

void MinAnglePlant::set_dead_path_mm(int index, double mm) {
  check(index != kTouchProbe, "the touch probe has no dead path");
  CellPlant::set_dead_path_mm(index, mm);
}

void MinAnglePlant::break_beam(TimeNs now, int index) {
  if (index != kTouchProbe) return CellPlant::break_beam(now, index);
  advance_to(now);
  knocked_off_ = true;
}

void MinAnglePlant::start_reference(int index, TimeNs now) {
  CellPlant::start_reference(index, now);
  knocked_off_ = false;
}

CellPlant::Beam MinAnglePlant::beam(int index, double time_s) const {
  const auto axis = static_cast<std::size_t>(index);
  Beam out;
  out.frame = world_.at(time_s);
  const MinAnglePose at = pose(time_s, out.frame);
  const Vec3 cube = cube_mm(at);
  const auto& b = parameters_.beams[axis];
  // Spot beside the cube's centre: the face that turns comes nearer or goes away there.
  const double abbe_mm = axis == 0   ? at.ry_rad * b.offset_v_mm - at.rz_rad * b.offset_u_mm
                         : axis == 1 ? at.rz_rad * b.offset_u_mm - at.rx_rad * b.offset_v_mm
                                     : at.rx_rad * b.offset_v_mm - at.ry_rad * b.offset_u_mm;
  const double along_mm = (axis == 0 ? cube.x : axis == 1 ? cube.y : cube.z) + abbe_mm;
  const double drift_mm = growth_mm(b.device, parameters_.reference_degc, out.frame.degc);
  out.true_nm = (along_mm + drift_mm) * kNmPerMm;
  out.disturbed_nm =
      disturbed(DisturbancePlace::interferometer_nm, {.time_s = time_s, .index = index});
  out.hidden_nm = hidden_beam_nm(index, out.frame, time_s, out.true_nm);
  const double tilt_rad = axis == 0   ? std::hypot(at.ry_rad, at.rz_rad)
                          : axis == 1 ? std::hypot(at.rx_rad, at.rz_rad)
                                      : std::hypot(at.rx_rad, at.ry_rad);
  out.lost = tilt_rad > parameters_.tilt_limit_arcsec * kRadPerArcsec;
  return out;
}

AngleReading MinAnglePlant::measure_angle(int index, double average_s, TimeNs end) {
  check(index >= 0 && index < collimator_count() && average_s >= 0,
        "angles: no such instrument, or no time to average");
  advance_to(end);
  const double middle_s = seconds(end) - average_s / 2;
  AngleReading reading = index == kInclinometer ? read_inclinometer(middle_s)
                                                : read_collimator(index, average_s, middle_s);
  reading.end = end;
  if (index != 0) note("length");  // the first autocollimator is never read alone
  return reading;
}

// Against the vertical: how far the end-effector's own y and x axes rise.
AngleReading MinAnglePlant::read_inclinometer(double middle_s) {
  const auto& p = parameters_.inclinometer;
  const MinAnglePose at = pose(middle_s);
  const auto shown_arcsec = [&](double rad) {
    const double deg =
        rad / kRadPerDegree + p.noise_arcsec / 3600 * angle_noise_[kInclinometer].gaussian();
    return std::round(std::clamp(deg, -p.range_deg, p.range_deg) / p.step_deg) * p.step_deg * 3600;
  };
  AngleReading reading;
  reading.y_arcsec = shown_arcsec(std::asin(std::cos(at.ry_rad) * std::sin(at.rx_rad)));
  reading.z_arcsec = shown_arcsec(at.ry_rad);
  return reading;
}

AngleReading MinAnglePlant::read_collimator(int index, double average_s, double middle_s) {
  const auto& c = parameters_.collimator;
  const Frame frame = world_.at(middle_s);
  const MinAnglePose at = pose(middle_s, frame);
  // Normals of the cube's faces, seen along x and along y.
  const double first_rad =
      index == 0 ? at.ry_rad
                 : std::atan2(std::cos(at.ry_rad) * std::sin(at.rx_rad), std::cos(at.rx_rad));
  const double second_rad =
      index == 0
          ? at.rz_rad
          : at.rz_rad - std::atan2(std::sin(at.ry_rad) * std::sin(at.rx_rad), std::cos(at.rx_rad));
  double mirror_arcsec = 0;
  if (index == 0) {
    const double structure_degc =
        frame.degc[static_cast<std::size_t>(parameters_.end_effector.x.parts.front())];
    mirror_arcsec = parameters_.mirror_arcsec_per_k * (structure_degc - parameters_.reference_degc);
  }
  const double quiet = std::sqrt(c.noise_s / (c.noise_s + average_s));
  Random& noise = angle_noise_[static_cast<std::size_t>(index)];
  AngleReading reading;
  reading.y_arcsec =
      first_rad / kRadPerArcsec + mirror_arcsec + quiet * c.noise_arcsec * noise.gaussian();
  reading.z_arcsec = second_rad / kRadPerArcsec + quiet * c.noise_arcsec * noise.gaussian();
  reading.position_wrong =
      std::abs(reading.y_arcsec) > c.range_arcsec || std::abs(reading.z_arcsec) > c.range_arcsec;
  return reading;
}

std::vector<std::string> MinAnglePlant::truth_columns() const {
  return pose_columns({"tip_nm", "room_degC", "pressure_hPa"});
}

std::vector<double> MinAnglePlant::truth_values(TimeNs at) {
  const double time_s = seconds(at);
  const Frame frame = world_.at(time_s);
  const MinAnglePose here = pose(time_s, frame);
  std::vector<double> values;
  for (const auto& axis : axes_) values.push_back(axis.commanded_mm() * kNmPerMm);
  for (std::size_t i = 0; i < kScrews; ++i)
    values.push_back(axes_[i].at(time_s, frame.hold_wander_nm[i]).counter_mm * kNmPerMm);
  for (const double mm : here.position_mm) values.push_back(mm * kNmPerMm);
  for (const double rad : {here.rx_rad, here.ry_rad, here.rz_rad})
    values.push_back(rad / kRadPerArcsec);
  values.push_back(tip_mm_ * kNmPerMm);
  values.push_back(frame.weather.room_degc);
  values.push_back(frame.weather.pressure_hpa);
  values.insert(values.end(), frame.degc.begin(),
                frame.degc.begin() + static_cast<long>(node_names().size()));
  add_hidden_values(frame, time_s, values);
  return values;
}

}  // namespace driftwise::simulated
