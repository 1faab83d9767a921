#pragma once
// Straight line through values over time, with standard uncertainties that allow for noise that is
// correlated in time (server/calibration/noise/serial_noise.h).

#include <optional>
#include <span>

#include "server/stability/samples.h"

namespace driftwise::stability {

struct Drift {
  double mean = 0, u_mean = 0;  // of the values
  double rate_per_h = 0, u_rate_per_h = 0;
  double noise = 0;  // standard deviation of one value about the line
};

// Evenly spaced values count as such; fewer than 8, or all at one instant: none.
std::optional<Drift> drift_of(std::span<const double> time_s, std::span<const double> values);

// Means of blocks of this length, from the first value on; a block without values is left out.
Samples block_means(const Samples& series, double block_s);

}  // namespace driftwise::stability
