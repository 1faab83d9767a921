#pragma once
// Noise whose spread goes with the place or with the hour: a beam in air is noisier the longer it
// is, and the air is quieter at night. Rows that are known better count for more, and what is
// simulated to tell chance has the same spread.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct Spread {
  // Standard deviation of every dataset row's noise over the others', rows x outputs; the mean
  // square over the learning rows is 1.
  Eigen::MatrixXd sd;
  std::vector<std::size_t> outputs;  // whose spread it is, ascending
  double gain = 0;                   // of 2 ln L, allowing for the kurtosis
};

// The logarithm of the variance is a polynomial of second degree, without products, in the pose
// coordinates, as far as the places determine it, fitted to the squares of what is left (whitened,
// clipped: a heavy tail is no place). Nothing where these squares do not go with the place beyond
// chance, by a Wald test that trusts no distribution (chance: about 1 in 1000).
// One polynomial for all outputs, or one for each output whose own squares go with the place: what
// explains more. An axis that turbulence reaches says nothing of one that it does not.
// ground: of the simulation with all that is named.
std::optional<Spread> spread_over_places(const Problem& problem, const Ground& ground);

// The same in time: a polynomial of second degree, and the cycle of the day where the data cover
// half a day. Nothing for data without times.
std::optional<Spread> spread_over_time(const Problem& problem, const Ground& ground);

}  // namespace driftwise::diagnosis
