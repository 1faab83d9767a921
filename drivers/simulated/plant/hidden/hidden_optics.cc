#include "drivers/simulated/plant/hidden/hidden_optics.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Of the refractivity of laboratory air, per kelvin at constant pressure: the handbook's figure,
// since eddies need no more.
constexpr double kIndexPerKelvin = -0.93e-6;

double phase_difference(double seen, double true_phase) {
  return std::remainder(seen - true_phase, kTurn);
}

}  // namespace

double ScaleSignalsMechanism::value_nm(const HiddenContext& at, double) const {
  const double phase =
      kTurn * std::remainder(at.stage_mm * kNmPerMm, signals_.period_nm) / signals_.period_nm;
  const double offset = signals_.offset_pct / 100;
  const double cosine = std::cos(phase) + offset;
  const double sine = (1 + signals_.amplitude_pct / 100) *
                      std::sin(phase + signals_.phase_deg * std::numbers::pi / 180);
  const double read_nm =
      signals_.period_nm * phase_difference(std::atan2(sine, cosine), phase) / kTurn;
  return -read_nm;
}

double FringeMixingMechanism::value_nm(const HiddenContext& at, double) const {
  const double fringe_nm = wavelength_nm_ / 2;
  const double phase = kTurn * std::remainder(at.path_mm * kNmPerMm, fringe_nm) / fringe_nm;
  const std::complex<double> light =
      std::polar(1.0, phase) + mixing_.ghost + mixing_.mixing * std::polar(1.0, -phase);
  return fringe_nm * phase_difference(std::arg(light), phase) / kTurn;
}

double LaserDriftMechanism::value_nm(const HiddenContext& at, double) const {
  const double hours = std::max(0.0, at.time_s / 3600);
  return -at.path_mm * drift_.ppm * (1 - std::exp(-hours / drift_.warm_up_h));  // mm x ppm = nm
}

void GlitchMechanism::step(const GridInstant& now) {
  if (now.time_s < 0) return;
  if (!drawn_ || now.time_s >= start_s_ + glitches_.seconds) {
    const double from_s = drawn_ ? start_s_ + glitches_.seconds : 0;
    start_s_ = from_s - std::log(random_.uniform()) * 3600 / glitches_.per_hour;
    size_nm_ = (random_.uniform() < 0.5 ? -1 : 1) * glitches_.nm;
    drawn_ = true;
  }
  nm_ = now.time_s >= start_s_ ? size_nm_ : 0;
}

double FanMechanism::value_nm(const HiddenContext& at, double memory) const {
  return at.time_s < 3600 * fan_.at_h ? 0 : at.path_mm * kNmPerMm * kIndexPerKelvin * memory;
}

LevelControlMechanism::LevelControlMechanism(const HiddenLevelControl& control, Random random)
    : control_(control) {
  fills_ = random.uniform() < 0.5;
  level_ = random.uniform(-1, 1);
}

void LevelControlMechanism::step(const GridInstant& now) {
  level_ += 2 * now.step_s * (fills_ ? 1 / control_.fill_s : -1 / control_.leak_s);
  if (level_ >= 1) fills_ = false;
  if (level_ <= -1) fills_ = true;
  seen_ += (1 - std::exp(-now.step_s / control_.lag_s)) * (level_ - seen_);
}

}  // namespace driftwise::simulated
