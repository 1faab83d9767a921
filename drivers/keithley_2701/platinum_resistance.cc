#include "drivers/keithley_2701/platinum_resistance.h"

#include <cmath>
#include <limits>

namespace driftwise::platinum {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

double ohm_from_degc(double t, const Probe& probe) {
  const double c_term = t < 0 ? kCPerDegc4 * (t - 100.0) * t * t * t : 0.0;
  return probe.r0_ohm * (1.0 + t * (probe.a_per_degc + t * probe.b_per_degc2) + c_term);
}

double degc_from_ohm(double ohm, const Probe& probe) {
  if (!(ohm >= ohm_from_degc(kMinDegc, probe) && ohm <= ohm_from_degc(kMaxDegc, probe)))
    return kNone;
  const double a = probe.a_per_degc, b = probe.b_per_degc2;
  const double ratio = ohm / probe.r0_ohm - 1.0;  // a t + b t^2
  const double discriminant = a * a + 4.0 * b * ratio;
  if (!(discriminant >= 0)) return kNone;
  // Written so that nothing cancels near 0 degC, and b = 0 is no special case.
  double t = 2.0 * ratio / (a + std::sqrt(discriminant));
  if (t >= 0) return t;
  for (int i = 0; i < 20; ++i) {
    const double slope = probe.r0_ohm * (a + 2.0 * b * t + kCPerDegc4 * t * t * (4.0 * t - 300.0));
    const double step = (ohm_from_degc(t, probe) - ohm) / slope;
    t -= step;
    if (std::abs(step) < 1e-10) return t;
  }
  return kNone;
}

}  // namespace driftwise::platinum
