#pragma once
// Middles and spreads that a few wrong values do not move.

#include <vector>

namespace driftwise::diagnosis {

// 0 of nothing; of an even count the upper of the two in the middle.
double median(std::vector<double> values);
// The standard deviation that normal values about zero with this median of |value| have.
double robust_sd(std::vector<double> values);

}  // namespace driftwise::diagnosis
