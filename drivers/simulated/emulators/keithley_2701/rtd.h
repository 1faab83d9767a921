#pragma once
// How the multimeter turns the resistance of a platinum probe into degrees Celsius: Callendar - Van
// Dusen with its own alpha, beta, delta (not the IEC 60751 coefficients; its PT100 is some mK off
// an IEC probe).
//   R = R0 (1 + A t + B t^2 + C (t - 100) t^3), C only below 0 degC,
//   A = alpha (1 + delta/100), B = -alpha delta 1e-4, C = -alpha beta 1e-8.
// Source: Keithley 2001 manual, page 4-156.

#include <optional>
#include <string_view>

namespace driftwise::simulated {

struct RtdConstants {
  double r0_ohm, alpha, beta, delta;
};

// PT100 D100 F100 PT385 PT3916, upper case.
std::optional<RtdConstants> rtd_constants(std::string_view type);

// nullopt outside -200..630 degC, the instrument's range.
std::optional<double> rtd_degc(double ohm, const RtdConstants& rtd);

}  // namespace driftwise::simulated
