#include "drivers/simulated/plant/cell/interferometer.h"

#include <cmath>

#include "drivers/simulated/plant/cell/refractive_index.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {

Interferometer::Interferometer(const InterferometerParameters& parameters, const Weather& typed_in,
                               std::size_t beam)
    : parameters_(parameters),
      beam_(beam),
      typed_in_(typed_in),
      typed_dead_path_mm_(parameters.dead_path_mm) {
  typed_in_.pressure_hpa = std::round(typed_in.pressure_hpa);
  typed_in_.humidity_pct = std::round(typed_in.humidity_pct);
}

double Interferometer::index(const Frame& frame) const {
  const double air_degc = frame.degc[static_cast<std::size_t>(parameters_.air_part)];
  return 1 + refractivity(parameters_.wavelength_nm, air_degc + frame.beams[beam_].beam_air_k,
                          frame.weather.pressure_hpa, frame.weather.humidity_pct);
}

double Interferometer::believed_index(const Frame& frame) const {
  return 1 + refractivity(parameters_.wavelength_nm, frame.beams[beam_].air_probe_degc,
                          typed_in_.pressure_hpa, typed_in_.humidity_pct);
}

double Interferometer::path_mm(double true_nm) const {
  return parameters_.dead_path_mm + parameters_.hidden_path_mm + true_nm / kNmPerMm;
}

double Interferometer::raw_nm(double true_nm, const Frame& frame) const {
  const double believed = believed_index(frame);
  const double optical_mm = index(frame) * path_mm(true_nm);
  const double dead_path_change_mm = (believed - believed_at_zero_) * typed_dead_path_mm_;
  return (optical_mm - path_at_zero_mm_ - dead_path_change_mm) / believed * kNmPerMm +
         frame.beams[beam_].instability_nm;
}

double Interferometer::shown_nm(double true_nm, const Frame& frame) const {
  return parameters_.sign * (raw_nm(true_nm, frame) - zero_nm_);
}

void Interferometer::zero(double true_nm, const Frame& frame, double offset_nm) {
  path_at_zero_mm_ = index(frame) * path_mm(true_nm);
  believed_at_zero_ = believed_index(frame);
  zero_nm_ = frame.beams[beam_].instability_nm + offset_nm;
}

}  // namespace driftwise::simulated
