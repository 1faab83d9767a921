#include "drivers/simulated/plant/micro_nano/autocollimator.h"

#include <cmath>
#include <numbers>
#include <string>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {

// Three sines of incommensurate periods.
double collimator_drift_arcsec(const CollimatorParameters& parameters, std::uint64_t seed,
                               int channel, double time_s) {
  Random random(seed, stream_of("collimator.drift", channel));
  double sum = 0;
  for (const double share : {1.0, 0.618, 0.382}) {
    const double phase = 2 * std::numbers::pi * random.uniform();
    sum += std::sin(2 * std::numbers::pi * time_s / (share * parameters.drift_s) + phase);
  }
  return parameters.drift_arcsec * std::sqrt(2.0 / 3.0) * sum;
}

double collimator_arcsec(const CollimatorParameters& parameters, const Machine::Collimator& device,
                         const std::array<double, 2>& true_rad, double offset_arcsec,
                         double drift_arcsec, double average_s, Random& noise) {
  const double quiet = std::sqrt(parameters.noise_s / (parameters.noise_s + average_s));
  const double turned_rad = true_rad[0] + device.roll_rad * true_rad[1];
  return device.gain * turned_rad / kRadPerArcsec + offset_arcsec + drift_arcsec +
         quiet * parameters.noise_arcsec * noise.gaussian();
}

}  // namespace driftwise::simulated
