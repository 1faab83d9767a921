#include "drivers/simulated/plant/hidden/hidden_thermal.h"

#include <algorithm>
#include <cmath>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kReference_degc = 20;  // ISO 1
// Of an explicit step: half of what is stable.
constexpr double kStableShare = 0.25;

int substeps(double rate_per_s, double step_s) {
  return std::max(1, static_cast<int>(std::ceil(rate_per_s * step_s / kStableShare)));
}

}  // namespace

SlabMechanism::SlabMechanism(const HiddenSlab& slab, double start_degc)
    : slab_(slab), slice_m_(slab.thickness_mm * 1e-3 / kSlices), start_degc_(start_degc) {
  degc_.fill(start_degc);
}

void SlabMechanism::step(const GridInstant& now) {
  const double outside_degc = (*now.degc)[static_cast<std::size_t>(slab_.part)];
  const double capacity = slab_.density_kg_m3 * slab_.heat_capacity_j_kgk * slice_m_;  // J/m2K
  const double through = slab_.conductivity_w_mk / slice_m_;                           // W/m2K
  const double entry = 1 / (1 / slab_.film_w_m2k + 0.5 / through);
  const int count = substeps((2 * through + entry) / capacity, now.step_s);
  const double dt_s = now.step_s / count;
  for (int k = 0; k < count; ++k) {
    std::array<double, kSlices + 1> flow_w_m2{};  // into slice i from below; none at the far face
    flow_w_m2[0] = entry * (outside_degc - degc_[0]);
    for (std::size_t i = 1; i < kSlices; ++i) flow_w_m2[i] = through * (degc_[i - 1] - degc_[i]);
    for (std::size_t i = 0; i < kSlices; ++i)
      degc_[i] += dt_s / capacity * (flow_w_m2[i] - flow_w_m2[i + 1]);
  }
  nm_ = slab_.bends ? sag_nm() : length_nm();
}

double SlabMechanism::length_nm() const {
  double mean_degc = 0;
  for (const double degc : degc_) mean_degc += degc / kSlices;
  return slab_.expansion_per_k * slab_.length_mm * kNmPerMm * (mean_degc - kReference_degc);
}

// A free plate whose temperature runs over its thickness bends to a radius: the first moment of the
// expansion (Boley & Weiner, Theory of Thermal Stresses, section 9.2), sag over the span.
double SlabMechanism::sag_nm() const {
  double moment = 0;  // of the temperature, K m2
  for (std::size_t i = 0; i < kSlices; ++i) {
    const double from_middle_m = (static_cast<double>(i) + 0.5 - kSlices / 2.0) * slice_m_;
    moment += degc_[i] * from_middle_m * slice_m_;
  }
  const double thickness_m = slab_.thickness_mm * 1e-3, span_m = slab_.length_mm * 1e-3;
  const double curvature_per_m =
      12 * slab_.expansion_per_k * moment / (thickness_m * thickness_m * thickness_m);
  return -curvature_per_m * span_m * span_m / 8 * 1e9;
}

void MotorHeatMechanism::step(const GridInstant& now) {
  const double mm = now.scale_mm[static_cast<std::size_t>(heat_.axis)];
  if (!started_) last_mm_ = mm;
  started_ = true;
  const double joule = heat_.heat_j_per_mm * std::abs(mm - last_mm_);
  last_mm_ = mm;
  const double fastest_per_s = std::max(heat_.link_w_k / heat_.drive_j_k,
                                        (heat_.link_w_k + heat_.sink_w_k) / heat_.carrier_j_k);
  const int count = substeps(fastest_per_s, now.step_s);
  const double dt_s = now.step_s / count;
  for (int k = 0; k < count; ++k) {
    const double across_w = heat_.link_w_k * (drive_k_ - carrier_k_);
    drive_k_ += (joule / count - dt_s * across_w) / heat_.drive_j_k;
    carrier_k_ += dt_s * (across_w - heat_.sink_w_k * carrier_k_) / heat_.carrier_j_k;
  }
}

double MotorHeatMechanism::memory() const {
  return heat_.expansion_per_k * heat_.length_mm * kNmPerMm * carrier_k_;
}

}  // namespace driftwise::simulated
