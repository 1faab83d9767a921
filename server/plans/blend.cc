#include "server/plans/blend.h"

#include <algorithm>
#include <cmath>

namespace driftwise::plans {
namespace {

double at(const Values& pose, const BandPart& part) {
  return pose[static_cast<std::size_t>(part.coordinate)];
}

// Integral of S(1 - u) over u from 0 to t: how far a saturating coordinate has moved; 1/2 at t = 1.
double saturated(double t) {
  const double s = 1 - t;
  // The integral of S from 0 to s: s^4 (5/2 - 3 s + s^2).
  const double integral = s * s * s * s * (2.5 - 3.0 * s + s * s);
  return 0.5 - integral;
}

}  // namespace

double smooth_step(double t) noexcept {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

double fine_weight(const Band& band, const Values& pose) noexcept {
  double weight = 1;
  for (std::size_t i = 0; i < band.parts; ++i)
    weight *= smooth_step((band.part[i].to - std::abs(at(pose, band.part[i]))) /
                          (band.part[i].to - band.part[i].from));
  return weight;
}

double anchor_fade(const Band& band, const Values& pose) noexcept {
  if (!band.anchored) return 0;
  double fade = 1;
  for (std::size_t i = 0; i < band.parts; ++i)
    fade *= smooth_step((band.part[i].fade_to - std::abs(at(pose, band.part[i]))) /
                        (band.part[i].fade_to - band.part[i].to));
  return fade;
}

Values held_at_border(const Band& band, Values pose) noexcept {
  for (std::size_t i = 0; i < band.parts; ++i) {
    double& value = pose[static_cast<std::size_t>(band.part[i].coordinate)];
    const double size = std::abs(value), width = band.part[i].to - band.part[i].from;
    if (size <= band.part[i].from) continue;
    const double moved = saturated(std::min(1.0, (size - band.part[i].from) / width)) * width;
    value = std::copysign(band.part[i].from + moved, value);
  }
  return pose;
}

}  // namespace driftwise::plans
