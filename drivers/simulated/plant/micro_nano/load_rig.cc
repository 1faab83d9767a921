#include "drivers/simulated/plant/micro_nano/load_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::simulated {

LoadRig::LoadRig(const LoadParameters& parameters, double wire_mm)
    : parameters_(parameters), settled_tension_n_(hanging_n(0)), settled_wire_mm_(wire_mm) {}

double LoadRig::hanging_n(double declared_n) const {
  return declared_n * parameters_.g_here_m_s2 / parameters_.g_declared_m_s2 + parameters_.pan_n;
}

double LoadRig::change_s() const {
  const double weights = std::ceil(std::abs(to_n_ - from_n_) / parameters_.weight_n - 1e-9);
  return std::max(1.0, weights) * parameters_.seconds_per_weight;
}

double LoadRig::declared_n(double time_s) const {
  const double share = std::clamp((time_s - start_s_) / change_s(), 0.0, 1.0);
  return from_n_ + share * (to_n_ - from_n_);
}

double LoadRig::tension_n(double time_s, double wire_mm) const {
  const auto& p = parameters_;
  const double weight_n = hanging_n(declared_n(time_s));
  const double band_n = p.friction * weight_n;
  // The longer the wire's end is drawn away, the tighter it is, until the pulleys slip.
  const double elastic_n = settled_tension_n_ + p.wire_n_mm * (wire_mm - settled_wire_mm_);
  const double tension_n = std::clamp(elastic_n, weight_n - band_n, weight_n + band_n);
  const double since_s = time_s - start_s_ - change_s();
  if (since_s < 0) return tension_n;
  const double swing = p.swing_share * std::exp(-since_s / p.swing_s) *
                       std::cos(2 * std::numbers::pi * since_s / p.swing_period_s);
  return tension_n * (1 + swing);
}

void LoadRig::settle(double time_s, double wire_mm) {
  settled_tension_n_ = tension_n(time_s, wire_mm);
  settled_wire_mm_ = wire_mm;
}

void LoadRig::set_newton(double newton, double now_s) {
  from_n_ = declared_n(now_s);
  to_n_ = jammed_ ? from_n_ : newton;
  start_s_ = now_s;
}

void LoadRig::set_jammed(bool jammed, double now_s) {
  // Stuck where it is; freed, it stays there until it is told again.
  set_newton(declared_n(now_s), now_s);
  jammed_ = jammed;
}

LoadState LoadRig::state(double now_s) const {
  const bool resting = !jammed_ && now_s >= start_s_ + change_s() + parameters_.rest_s;
  return {.newton = declared_n(now_s),
          .resting = resting,
          .jammed = jammed_,
          .max_newton = parameters_.max_n};
}

}  // namespace driftwise::simulated
