#include "drivers/simulated/emulators/keithley_2701/rtd.h"

#include <cmath>

namespace driftwise::simulated {

std::optional<RtdConstants> rtd_constants(std::string_view type) {
  if (type == "PT100") return RtdConstants{100, .003850, .10863, 1.49990};
  if (type == "D100") return RtdConstants{100, .003920, .10630, 1.49710};
  if (type == "F100") return RtdConstants{100, .003900, .11000, 1.49589};
  if (type == "PT385") return RtdConstants{100, .003850, .11100, 1.50700};
  if (type == "PT3916") return RtdConstants{100, .003916, .11600, 1.50594};
  return std::nullopt;
}

std::optional<double> rtd_degc(double ohm, const RtdConstants& rtd) {
  if (!std::isfinite(ohm)) return std::nullopt;
  const double a = rtd.alpha * (1 + rtd.delta / 100);
  const double b = -rtd.alpha * rtd.delta * 1e-4;
  const double c = -rtd.alpha * rtd.beta * 1e-8;
  const double ratio = ohm / rtd.r0_ohm;
  // Bisection over the range the instrument knows: the curve rises there, and any constants a user
  // may set are safe.
  const auto curve = [&](double t) {
    return 1 + a * t + b * t * t + (t < 0 ? c * (t - 100) * t * t * t : 0.0);
  };
  double low = -200, high = 630;
  if (!(ratio >= curve(low) && ratio <= curve(high))) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (curve(middle) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace driftwise::simulated
