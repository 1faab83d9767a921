#pragma once
// Conversions used at the edges, by name. Inside, a number's unit is in its name.

#include <numbers>

namespace driftwise {

constexpr double kRadPerArcsec = std::numbers::pi / (180.0 * 3600.0);  // by definition
constexpr double kRadPerDeg = std::numbers::pi / 180.0;                // by definition
constexpr double kNmPerMm = 1e6;
constexpr double kSigmaToU90 = 1.645;  // U90 = 1.645 sigma: the accuracy figure used throughout

constexpr double rad_from_arcsec(double arcsec) { return arcsec * kRadPerArcsec; }
constexpr double arcsec_from_rad(double rad) { return rad / kRadPerArcsec; }
constexpr double nm_from_mm(double mm) { return mm * kNmPerMm; }
constexpr double mm_from_nm(double nm) { return nm / kNmPerMm; }
constexpr double degc_from_degf(double degf) { return (degf - 32.0) / 1.8; }
constexpr double degf_from_degc(double degc) { return degc * 1.8 + 32.0; }

}  // namespace driftwise
