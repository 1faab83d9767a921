#pragma once
// Size of the white part of the noise, in the summary unit: the unit of whitened rows. A type of
// its own, because a row's noise has other sizes too (what neighbouring rows differ by, what all
// rows scatter by), and in slow noise those are many times larger: a prior that is weighed by one
// of them against whitened rows holds an amplitude back to a fraction of what it is.

#include <cmath>

namespace driftwise::diagnosis {

struct WhiteSd {
  double value = 0;
};

// Precision of an amplitude with the prior N(0, prior_sd^2), as whitened rows take it: as
// SoftBase::precision. prior_sd: in the summary unit per unit of the column, above 0.
inline double whitened_precision(WhiteSd noise, double prior_sd) {
  return std::pow(noise.value / prior_sd, 2);
}

}  // namespace driftwise::diagnosis
