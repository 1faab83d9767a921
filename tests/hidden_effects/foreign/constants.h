#pragma once

#include <numbers>
#include <vector>

namespace driftwise::foreign {

inline constexpr double kTurn = 2.0 * std::numbers::pi;
// By definition.
inline constexpr double kRadPerArcsec = std::numbers::pi / (180.0 * 3600.0);

// Periods that interpolation errors have, mm or arcsec.
//
// Interferometer: 633 nm over 1, 2, 4, 8. Scale: graduations of 512 nm to 40 um, screws and racks
// of 1 to 20 mm. Angles: 64000 to 36 lines per turn; autocollimator pixels of some arcsec.
inline std::vector<double> periods(bool angle, bool scale) {
  if (angle) {
    return scale ? std::vector<double>{20.25, 36.0, 72.0, 129.6, 3600.0, 7200.0}
                 : std::vector<double>{2.0, 5.0, 12.0, 36.0};
  }
  return scale ? std::vector<double>{0.512e-3, 2e-3, 4e-3, 8e-3, 20e-3, 40e-3,
                                     1.0,      2.0,  5.0,  10.0, 20.0}
               : std::vector<double>{79.1e-6, 158.2e-6, 316.4e-6, 632.8e-6};
}

}  // namespace driftwise::foreign
