#pragma once
// Noise whose spread goes with the place: a beam in air is noisier the longer it is. Rows that are
// known better count for more, and what is simulated to tell chance has the same spread.

#include <Eigen/Core>
#include <optional>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Standard deviation of every dataset row's noise over the others', its mean square over the
// learning rows 1: the logarithm of the variance is a polynomial of second degree, without
// products, in the pose coordinates, fitted to the squares of what is left (whitened, clipped: a
// heavy tail is no place). Nothing where these squares do not go with the place beyond chance, by a
// Wald test that trusts no distribution (chance: about 1 in 1000).
// ground: of the simulation with all that is named.
std::optional<Eigen::VectorXd> spread_over_places(const Problem& problem, const Ground& ground);

}  // namespace driftwise::diagnosis
