#pragma once

namespace driftwise::platinum {

// A platinum resistance thermometer after Callendar and Van Dusen (IEC 60751):
//   t >= 0 degC:  R(t) = R0 (1 + A t + B t^2)
//   t <  0 degC:  R(t) = R0 (1 + A t + B t^2 + C (t - 100) t^3)
// with A, B from the probe's own calibration; C is the standard's for all (it matters below 0 degC
// only, where nobody calibrates a probe of a machine room).
struct Probe {
  double r0_ohm = 1000.0;
  double a_per_degc = 3.9083e-3;   // IEC 60751
  double b_per_degc2 = -5.775e-7;  // IEC 60751
};

inline constexpr double kCPerDegc4 = -4.183e-12;              // IEC 60751
inline constexpr double kMinDegc = -200.0, kMaxDegc = 850.0;  // the standard's range

double ohm_from_degc(double degc, const Probe& probe);
// The inverse: closed form above zero, Newton below (to better than 1e-9 K). NaN for what lies
// outside the standard's range or is no number.
double degc_from_ohm(double ohm, const Probe& probe);

}  // namespace driftwise::platinum
