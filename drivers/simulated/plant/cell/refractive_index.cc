#include "drivers/simulated/plant/cell/refractive_index.h"

#include <cmath>

namespace driftwise::simulated {

double refractivity(double wavelength_nm, double air_degc, double pressure_hpa,
                    double humidity_pct) {
  const double waves_per_um = 1e3 / wavelength_nm;
  const double s2 = waves_per_um * waves_per_um;
  const double standard = (8342.54 + 2406147.0 / (130.0 - s2) + 15998.0 / (38.9 - s2)) * 1e-8;
  const double pressure_pa = pressure_hpa * 100;
  const double dry = pressure_pa * standard / 96095.43 *
                     (1 + 1e-8 * (0.601 - 0.00972 * air_degc) * pressure_pa) /
                     (1 + 0.0036610 * air_degc);
  const double vapour_pa =
      humidity_pct / 100 * 611.2 * std::exp(17.62 * air_degc / (243.12 + air_degc));
  return dry - vapour_pa * (3.7345 - 0.0401 * s2) * 1e-10;
}

}  // namespace driftwise::simulated
