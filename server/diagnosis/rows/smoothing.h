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

// Several thermometers of one machine. A cycle of the room that is faster than the sampling is no
// line to a neighbour in time, and would go with the noise; but all thermometers follow it, and
// their noises are their own. What the lines take from one is given back as far as the others
// foretell it. values: one vector per thermometer, each as long as time_s.
std::vector<std::vector<double>> smoothed_together(std::span<const double> time_s,
                                                   const std::vector<std::vector<double>>& values);

}  // namespace driftwise::diagnosis
