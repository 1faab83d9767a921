#include "drivers/simulated/plant/hidden/hidden_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

// How far the axis went since the last step; 0 at the first.
double travelled_mm(double now_mm, double& last_mm, bool& started) {
  const double mm = started ? now_mm - last_mm : 0;
  started = true;
  last_mm = now_mm;
  return mm;
}

}  // namespace

void FrictionMechanism::step(const GridInstant& now) {
  const double mm =
      travelled_mm(now.scale_mm[static_cast<std::size_t>(friction_.axis)], last_mm_, started_);
  for (std::size_t i = 0; i < kSliders; ++i) {
    const double loose_mm = kBreak[i] * friction_.presliding_um * 1e-3;
    drawn_mm_[i] = std::clamp(drawn_mm_[i] + mm, -loose_mm, loose_mm);
  }
}

// The stage stays behind its scale by force over stiffness.
double FrictionMechanism::memory() const {
  double share = 0;
  for (std::size_t i = 0; i < kSliders; ++i)
    share += drawn_mm_[i] / (kBreak[i] * friction_.presliding_um * 1e-3) / kSliders;
  return -share * friction_.friction_n / friction_.stiffness_n_um * 1e3;
}

void ViscoelasticMechanism::step(const GridInstant& now) {
  const double mm =
      travelled_mm(now.scale_mm[static_cast<std::size_t>(glue_.axis)], last_mm_, started_);
  for (std::size_t i = 0; i < late_mm_.size(); ++i) {
    const double steps = now.step_s / glue_.times_s[i];
    const double kept = std::exp(-steps);
    late_mm_[i] = kept * late_mm_[i] + glue_.share_ppm * 1e-6 / 3 * mm * (1 - kept) / steps;
  }
}

double ViscoelasticMechanism::memory() const {
  return -kNmPerMm * (late_mm_[0] + late_mm_[1] + late_mm_[2]);
}

// Rolled over: a raised cosine.
double ParticleMechanism::value_nm(const HiddenContext& at, double) const {
  const double off = std::abs(at.stage_mm - particle_.at_mm) / particle_.half_width_mm;
  return off < 1 ? 0.5 * particle_.nm * (1 + std::cos(std::numbers::pi * off)) : 0;
}

double BallContactMechanism::value_nm(const HiddenContext& at, double) const {
  constexpr double kPoisson = 0.3;
  const double effective_pa = ball_.youngs_gpa * 1e9 / (2 * (1 - kPoisson * kPoisson));
  const double force_n = std::max(0.0, at.force_n);
  return 1e9 * std::cbrt(9 * force_n * force_n /
                         (16 * ball_.radius_mm * 1e-3 * effective_pa * effective_pa));
}

}  // namespace driftwise::simulated
