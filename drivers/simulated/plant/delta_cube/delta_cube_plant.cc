#include "drivers/simulated/plant/delta_cube/delta_cube_plant.h"

#include <cmath>

#include "drivers/simulated/plant/micro_nano/autocollimator.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr PerArm<Vec3> kLooksAgainst{Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}};
constexpr PerArm<Vec3> kFaceU{Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{1, 0, 0}};
constexpr PerArm<Vec3> kFaceV{Vec3{0, 0, 1}, Vec3{0, 0, 1}, Vec3{0, 1, 0}};

}  // namespace

DeltaCubePlant::DeltaCubePlant(DeltaCubeParameters parameters, std::uint64_t seed, TimeNs epoch)
    : CellPlant(std::make_unique<const DeltaCubeParameters>(std::move(parameters)), seed, epoch),
      parameters_(static_cast<const DeltaCubeParameters&>(cell())),
      machine_(made_delta_cube(parameters_, parameters_.machine != 0 ? parameters_.machine : seed)),
      mechanics_(parameters_, machine_) {
  NodeTemperatures reference{};
  reference.fill(parameters_.reference_degc);
  const PlatformPose zero = mechanics_.pose({}, reference);
  reference_centre_mm_ = mechanics_.on_platform(zero, parameters_.cube.centre_mm, reference);
  reference_turn_ = inverse(zero.turn);
  for (int i = 0; i < collimator_count(); ++i) {
    angle_noise_.emplace_back(seed, stream_of("collimator.reading", i));
  }
  zero_at_start();
}

const DeltaCubePlant::Instant& DeltaCubePlant::instant(double time_s) const {
  return recent_.at(time_s, now_, [this](Instant& one) { solve(one); });
}

void DeltaCubePlant::solve(Instant& i) const {
  i.frame = world_.at(i.time_s);
  PerArm<double> stage_mm{};
  for (std::size_t k = 0; k < kArms; ++k) {
    i.servo[k] = axes_[k].at(i.time_s, i.frame.hold_wander_nm[k]);
    stage_mm[k] = mechanics_.stage_from_scale_mm(k, i.servo[k].scale_mm, i.frame.degc);
    if (parameters_.hidden.empty()) continue;
    stage_mm[k] += hidden_stage_nm(static_cast<int>(k), i.frame,
                                   {.time_s = i.time_s, .stage_mm = i.servo[k].scale_mm}) /
                   kNmPerMm;
  }
  const PlatformPose pose = mechanics_.pose(stage_mm, i.frame.degc);
  i.cube = pose.turn * reference_turn_;
  i.centre_mm = mechanics_.on_platform(pose, parameters_.cube.centre_mm, i.frame.degc);
}

CubeFace DeltaCubePlant::face(std::size_t axis, const Instant& at) const {
  const auto& mirror = machine_.mirrors[axis];
  const double half_mm = parameters_.cube.edge_mm / 2;
  return {.middle_mm = at.centre_mm + half_mm * (at.cube * kLooksAgainst[axis]),
          .normal = at.cube * mirror.normal,
          .first = at.cube * kFaceU[axis],
          .second = at.cube * kFaceV[axis],
          .half_edge_mm = half_mm,
          .figure_nm = mirror.figure};
}

// From the head, which stands where its dead path ends at the zero pose; what its support's warmth
// does to it is added to the path.
LightRay DeltaCubePlant::ray(std::size_t axis) const {
  const auto& nominal = parameters_.beams[axis];
  const auto& error = machine_.spot_error_mm[axis];
  const Vec3 spot = reference_centre_mm_ + (parameters_.cube.edge_mm / 2) * kLooksAgainst[axis] +
                    (nominal.offset_u_mm + error[0]) * kFaceU[axis] +
                    (nominal.offset_v_mm + error[1]) * kFaceV[axis];
  const Vec3 along = unit(-1.0 * machine_.mirrors[axis].normal + machine_.beam_error_rad[axis]);
  return {.from_mm = spot - parameters_.interferometers[axis].dead_path_mm * along, .along = along};
}

CellPlant::Beam DeltaCubePlant::beam(int index, double time_s) const {
  const auto axis = static_cast<std::size_t>(index);
  const Instant& at = instant(time_s);
  const PathReading reading = path_to(ray(axis), face(axis, at));
  const auto& b = parameters_.beams[axis];
  const double reference = parameters_.reference_degc;
  const double grown_mm =
      growth_mm(b.datum, reference, at.frame.degc) + growth_mm(b.device, reference, at.frame.degc);
  const double dead_mm = parameters_.interferometers[axis].dead_path_mm;
  const double true_nm = (reading.path_mm + grown_mm - dead_mm) * kNmPerMm;
  return {.frame = at.frame,
          .true_nm = true_nm,
          .disturbed_nm = disturbed(DisturbancePlace::interferometer_nm,
                                    {.time_s = time_s,
                                     .index = index,
                                     .approach = at.servo.front().approach,
                                     .since_move_s = at.servo.front().since_end_s}),
          .hidden_nm = hidden_beam_nm(index, at.frame, time_s, true_nm),
          .lost = reading.tilt_rad > parameters_.optics.tilt_limit_arcsec * kRadPerArcsec};
}

AngleReading DeltaCubePlant::measure_angle(int index, double average_s, TimeNs end) {
  check(index >= 0 && index < collimator_count() && average_s >= 0,
        "autocollimator: no such one, or no time to average");
  advance_to(end);
  const auto which = static_cast<std::size_t>(index);
  const auto& c = parameters_.collimator;
  const auto& device = machine_.collimators[which];
  const double middle_s = seconds(end) - average_s / 2;
  const Rotation& cube = instant(middle_s).cube;
  // The mirror's normal against the device's axis: what the returning spot shows.
  const Vec3 n = which == 0 ? cube.ex : cube.ez;
  const double first_rad = which == 0 ? std::atan2(-n.z, n.x) : std::atan2(-n.y, n.z);
  const double second_rad = which == 0 ? std::atan2(n.y, n.x) : std::atan2(n.x, n.z);
  const auto shown = [&](double true_rad, double cross_rad, double offset_arcsec, int channel) {
    double drift_arcsec =
        collimator_drift_arcsec(c, seed_, 2 * static_cast<int>(which) + channel, middle_s);
    if (which == 0 && channel == 0 && c.mirror_arcsec_per_k != 0)
      drift_arcsec += c.mirror_arcsec_per_k *
                      (world_.at(middle_s).degc[static_cast<std::size_t>(c.mirror_part)] -
                       parameters_.reference_degc);
    return collimator_arcsec(c, device, {true_rad, cross_rad}, offset_arcsec, drift_arcsec,
                             average_s, angle_noise_[which]);
  };
  AngleReading reading{.y_arcsec = shown(first_rad, second_rad, device.y_offset_arcsec, 0),
                       .z_arcsec = shown(second_rad, -first_rad, device.z_offset_arcsec, 1),
                       .end = end};
  reading.position_wrong =
      std::abs(reading.y_arcsec) > c.range_arcsec || std::abs(reading.z_arcsec) > c.range_arcsec;
  return reading;
}

DeltaCubePlant::Pose DeltaCubePlant::pose(double time_s) const {
  const Instant at = instant(time_s);
  Pose pose;
  pose.position_nm = to_array(kNmPerMm * (at.centre_mm - reference_centre_mm_));
  pose.rotation_arcsec = to_array((1 / kRadPerArcsec) * rotation_vector(at.cube));
  for (std::size_t k = 0; k < kArms; ++k) {
    const auto& b = parameters_.beams[k];
    pose.position_nm[k] +=
        b.sign * kNmPerMm * growth_mm(b.datum, parameters_.reference_degc, at.frame.degc);
  }
  return pose;
}

std::vector<std::string> DeltaCubePlant::truth_columns() const {
  return pose_columns({"room_degC", "pressure_hPa"});
}

std::vector<double> DeltaCubePlant::truth_values(TimeNs at) {
  const double time_s = seconds(at);
  const Instant here = instant(time_s);
  const Pose posed = pose(time_s);
  std::vector<double> values;
  for (const auto& axis : axes_) values.push_back(axis.commanded_mm() * kNmPerMm);
  for (const auto& servo : here.servo) values.push_back(servo.counter_mm * kNmPerMm);
  values.insert(values.end(), posed.position_nm.begin(), posed.position_nm.end());
  values.insert(values.end(), posed.rotation_arcsec.begin(), posed.rotation_arcsec.end());
  values.push_back(here.frame.weather.room_degc);
  values.push_back(here.frame.weather.pressure_hpa);
  values.insert(values.end(), here.frame.degc.begin(),
                here.frame.degc.begin() + static_cast<long>(node_names().size()));
  add_hidden_values(here.frame, time_s, values);
  return values;
}

}  // namespace driftwise::simulated
