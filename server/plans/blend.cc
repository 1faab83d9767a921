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

double distance_of(const BandPart& part, double value) noexcept {
  const double offset = value - part.centre;
  if (part.side == BandSide::above) return std::max(0.0, offset);
  if (part.side == BandSide::below) return std::max(0.0, -offset);
  return std::abs(offset);
}

double reach_of(const BandPart& part, double min, double max) noexcept {
  if (part.side == BandSide::above) return max - part.centre;
  if (part.side == BandSide::below) return part.centre - min;
  return std::min(part.centre - min, max - part.centre);
}

double smooth_step(double t) noexcept {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

double fine_weight(const Band& band, const Values& pose) noexcept {
  double weight = 1;
  for (std::size_t i = 0; i < band.parts; ++i)
    weight *= smooth_step((band.part[i].to - distance_of(band.part[i], at(pose, band.part[i]))) /
                          (band.part[i].to - band.part[i].from));
  return weight;
}

double anchor_fade(const Band& band, const Values& pose) noexcept {
  if (!band.anchored) return 0;
  double fade = 1;
  for (std::size_t i = 0; i < band.parts; ++i)
    fade *= smooth_step((band.part[i].fade_to - distance_of(band.part[i], at(pose, band.part[i]))) /
                        (band.part[i].fade_to - band.part[i].to));
  return fade;
}

Values held_at_border(const Band& band, Values pose) noexcept {
  for (std::size_t i = 0; i < band.parts; ++i) {
    const BandPart& part = band.part[i];
    double& value = pose[static_cast<std::size_t>(part.coordinate)];
    const double distance = distance_of(part, value), width = part.to - part.from;
    if (distance <= part.from) continue;
    const double moved = saturated(std::min(1.0, (distance - part.from) / width)) * width;
    value = part.centre + std::copysign(part.from + moved, value - part.centre);
  }
  return pose;
}

}  // namespace driftwise::plans
