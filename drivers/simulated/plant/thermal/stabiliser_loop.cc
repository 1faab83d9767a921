#include "drivers/simulated/plant/thermal/stabiliser_loop.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {
namespace {
constexpr double kKelvinAtZeroDegc = 273.15;
}

StabiliserLoop::StabiliserLoop(const StabiliserParameters& parameters, std::uint64_t seed,
                               double step_s, double start_degc, int index)
    : parameters_(parameters),
      noise_(seed, stream_of("stabiliser.sensor", index)),
      drift_(parameters.sensor_drift_k, parameters.sensor_drift_s, step_s,
             Random(seed, stream_of("stabiliser.drift", index))),
      step_s_(step_s),
      keep_(std::exp(-step_s / parameters.sensor_s)),
      sensor_degc_(start_degc),
      process_degc_(start_degc),
      previous_degc_(start_degc),
      set_point_degc_(parameters.set_point_degc),
      mode_(parameters.mode) {}

double StabiliserLoop::controlled_pct() {
  const auto& p = parameters_;
  const double error_k = set_point_degc_ - process_degc_;
  // The band follows the side the output is on, as in a heat-cool controller.
  const double band_k = output_pct_ >= 0 ? p.heat_band_k : p.cool_band_k;
  const double rate_k_s = (process_degc_ - previous_degc_) / step_s_;
  const double direct_pct = 100 * (error_k - p.derivative_s * rate_k_s) / band_k;
  double integral_pct = integral_pct_;
  if (p.integral_s > 0) integral_pct += 100 * error_k / band_k * step_s_ / p.integral_s;
  const double wanted_pct = direct_pct + integral_pct;
  const bool winding_up = std::abs(wanted_pct) > 100 && wanted_pct * error_k > 0;
  if (!winding_up) integral_pct_ = std::clamp(integral_pct, -100.0, 100.0);
  return std::clamp(direct_pct + integral_pct_, -100.0, 100.0);
}

PeltierHeat StabiliserLoop::step(double support_degc, double sink_degc) {
  const auto& p = parameters_;
  sensor_degc_ = support_degc + keep_ * (sensor_degc_ - support_degc);
  previous_degc_ = process_degc_;
  process_degc_ = sensor_degc_ + drift_.step() + p.sensor_noise_k * noise_.gaussian();
  if (mode_ == Plant::StabiliserMode::off || sensor_open_) {
    output_pct_ = 0;  // a broken sensor must not heat
  } else if (mode_ == Plant::StabiliserMode::manual) {
    output_pct_ = manual_pct_;
  } else {
    output_pct_ = controlled_pct();
  }
  const double current_a = output_pct_ / 100 * p.current_limit_a;
  const double joule_w = p.resistance_ohm * current_a * current_a / 2;
  return {.support_w = p.seebeck_v_k * (support_degc + kKelvinAtZeroDegc) * current_a + joule_w,
          .sink_w = -p.seebeck_v_k * (sink_degc + kKelvinAtZeroDegc) * current_a + joule_w};
}

StabiliserState StabiliserLoop::state() const {
  const double grain_k = parameters_.process_resolution_k;
  return {.process_degc = std::round(process_degc_ / grain_k) * grain_k,
          .set_point_degc = set_point_degc_,
          .heat_pct = std::max(output_pct_, 0.0),
          .cool_pct = std::max(-output_pct_, 0.0),
          .sensor_open = sensor_open_};
}

void StabiliserLoop::set_mode(Plant::StabiliserMode mode, double manual_pct) {
  // Back to automatic from where the output is: no bump.
  if (mode == Plant::StabiliserMode::automatic && mode_ != mode) integral_pct_ = output_pct_;
  mode_ = mode;
  manual_pct_ = std::clamp(manual_pct, -100.0, 100.0);
}

void StabiliserLoop::set_tuning(double heat_band_k, double cool_band_k, double ti_s, double td_s) {
  parameters_.heat_band_k = heat_band_k;
  parameters_.cool_band_k = cool_band_k;
  parameters_.integral_s = ti_s;
  parameters_.derivative_s = td_s;
}

void StabiliserLoop::set_sensor_open(bool open) {
  sensor_open_ = open;
  integral_pct_ = 0;
}

}  // namespace driftwise::simulated
