#pragma once

namespace driftwise::simulated {

// n - 1 of air at a vacuum wavelength: Birch & Downs 1994 (the updated Edlen equation), good to
// 1e-8 in a laboratory. Humidity acts by the vapour pressure over water after Magnus.
double refractivity(double wavelength_nm, double air_degc, double pressure_hpa,
                    double humidity_pct);

}  // namespace driftwise::simulated
