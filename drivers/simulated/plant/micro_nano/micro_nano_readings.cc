// What the Micro-Nano's autocollimators show, and its truth.

#include <algorithm>
#include <cmath>

#include "drivers/simulated/plant/micro_nano/autocollimator.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_plant.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

std::array<double, 3> in_nm(Vec3 mm) { return {mm.x * kNmPerMm, mm.y * kNmPerMm, mm.z * kNmPerMm}; }

}  // namespace

double MicroNanoPlant::drift_arcsec(std::size_t index, double time_s) const {
  const auto& c = parameters_.collimator;
  const double by_itself = collimator_drift_arcsec(c, seed_, static_cast<int>(index), time_s);
  if (index != 0 || c.mirror_arcsec_per_k == 0) return by_itself;
  const double mount_degc = world_.at(time_s).degc[static_cast<std::size_t>(c.mirror_part)];
  return by_itself + c.mirror_arcsec_per_k * (mount_degc - parameters_.reference_degc);
}

AngleReading MicroNanoPlant::measure_angle(int index, double average_s, TimeNs end) {
  check(index >= 0 && index < collimator_count() && average_s >= 0,
        "autocollimator: no such one, or no time to average");
  advance_to(end);
  const auto which = static_cast<std::size_t>(index);
  const auto& c = parameters_.collimator;
  const auto& device = machine_.collimators[which];
  const double middle_s = seconds(end) - average_s / 2;
  const Rotation& cube = instant(middle_s).cube;
  // The mirror's normal against the device's axis: exactly what the returning spot shows.
  const Vec3 n = which == 0 ? cube.ex : cube.ey;
  const double y_rad = which == 0 ? std::atan2(-n.z, n.x) : std::atan2(n.z, n.y);
  const double z_rad = which == 0 ? std::atan2(n.y, n.x) : std::atan2(-n.x, n.y);
  const auto shown = [&](double true_rad, double cross_rad, double offset_arcsec,
                         std::size_t channel) {
    return collimator_arcsec(c, device, {true_rad, cross_rad}, offset_arcsec,
                             drift_arcsec(2 * which + channel, middle_s), average_s,
                             angle_noise_[which]);
  };
  AngleReading reading{.y_arcsec = shown(y_rad, z_rad, device.y_offset_arcsec, 0),
                       .z_arcsec = shown(z_rad, -y_rad, device.z_offset_arcsec, 1),
                       .end = end};
  const CollimatorFault fault = collimator_faults_[which];
  reading.power_wrong = fault == CollimatorFault::wrong_power;
  reading.position_wrong = fault == CollimatorFault::wrong_position ||
                           std::abs(reading.y_arcsec) > c.range_arcsec ||
                           std::abs(reading.z_arcsec) > c.range_arcsec;
  return reading;
}

PoseTruth MicroNanoPlant::truth(TimeNs at) {
  const Instant i = instant(seconds(at));
  PoseTruth truth{
      .time = at,
      .declared_n = load_.state(seconds(at)).newton,
      .air_degc =
          i.frame.degc[static_cast<std::size_t>(parameters_.interferometers.front().air_part)],
      .room_degc = i.frame.weather.room_degc,
      .pressure_hpa = i.frame.weather.pressure_hpa};
  truth.position_nm = in_nm(i.centre_mm - reference_centre_mm_);
  truth.rotation_arcsec = to_array((1 / kRadPerArcsec) * rotation_vector(i.cube));
  truth.force_n = i.tension_n - parameters_.load.pan_n;
  for (std::size_t k = 0; k < kArms; ++k) {
    truth.commanded_nm[k] = axes_[k].commanded_mm() * kNmPerMm;
    truth.q_scale_nm[k] = i.servo[k].counter_mm * kNmPerMm;
    const auto& b = parameters_.beams[k];
    const double reference = parameters_.reference_degc;
    truth.position_nm[k] += b.sign * kNmPerMm * growth_mm(b.datum, reference, i.frame.degc);
    truth.device_drift_nm[k] = b.sign * kNmPerMm * growth_mm(b.device, reference, i.frame.degc);
    const Beam seen = beam(static_cast<int>(k), i.time_s);
    truth.path_true_nm[k] = b.sign * seen.true_nm;
    truth.air_error_nm[k] =
        shown_nm(static_cast<int>(k), seen) - b.sign * (seen.true_nm - true_at_zero_nm_[k]);
  }
  truth.node_degc.assign(i.frame.degc.begin(),
                         i.frame.degc.begin() + static_cast<long>(node_names().size()));
  return truth;
}

std::vector<std::string> MicroNanoPlant::truth_columns() const {
  return pose_columns({"x_path_nm", "y_path_nm", "z_path_nm", "x_device_drift_nm",
                       "y_device_drift_nm", "z_device_drift_nm", "x_air_error_nm", "y_air_error_nm",
                       "z_air_error_nm", "force_N", "declared_N", "air_degC", "room_degC",
                       "pressure_hPa"});
}

std::vector<double> MicroNanoPlant::truth_values(TimeNs at) {
  const PoseTruth t = truth(at);
  std::vector<double> values;
  for (const auto* group : {&t.commanded_nm, &t.q_scale_nm, &t.position_nm, &t.rotation_arcsec,
                            &t.path_true_nm, &t.device_drift_nm, &t.air_error_nm}) {
    values.insert(values.end(), group->begin(), group->end());
  }
  for (const double value : {t.force_n, t.declared_n, t.air_degc, t.room_degc, t.pressure_hpa}) {
    values.push_back(value);
  }
  values.insert(values.end(), t.node_degc.begin(), t.node_degc.end());
  add_hidden_values(world_.at(seconds(at)), seconds(at), values);
  return values;
}

}  // namespace driftwise::simulated
