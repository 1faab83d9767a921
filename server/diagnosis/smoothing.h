#pragma once
// A thermometer's noise is itself an effect: a filtered sensor predicts better than a raw one, so a
// short lag wins on data with nothing in them (NUMERICS.md section 3). Temperatures are therefore
// smoothed first.

#include <span>
#include <vector>

namespace driftwise::diagnosis {

// Local straight lines under a Gaussian kernel, as wide as predicts each value best from its
// neighbours without itself; lines, so the ends are as honest as the middle and leave no transient.
// A signal that changes as fast as it is sampled stays as it is. time_s: ascending, one per value;
// missing values stay missing.
std::vector<double> smoothed(std::span<const double> time_s, std::span<const double> values);

}  // namespace driftwise::diagnosis
