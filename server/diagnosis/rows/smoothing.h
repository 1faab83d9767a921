#pragma once
// A thermometer's noise is itself an effect: a filtered sensor predicts better than a raw one, so a
// short lag wins on data with nothing in them (NUMERICS.md section 3). Temperatures are therefore
// smoothed first.

#include <Eigen/Core>
#include <span>
#include <vector>

namespace driftwise::diagnosis {

// Local straight lines under a Gaussian kernel, as wide as predicts each value best from its
// neighbours without itself; lines, so the ends are as honest as the middle and leave no transient.
// A temperature that changes as fast as it is sampled goes with the noise: share_followed() gives
// it back. time_s: ascending, one per value; missing values stay missing.
std::vector<double> smoothed(std::span<const double> time_s, std::span<const double> values);

// Several thermometers of one machine. A cycle of the room that is faster than the sampling is no
// line to a neighbour in time, and would go with the noise; but all thermometers follow it, and
// their noises are their own. What the lines take from one is given back as far as the others
// foretell it. values: one vector per thermometer, each as long as time_s.
std::vector<std::vector<double>> smoothed_together(std::span<const double> time_s,
                                                   const std::vector<std::vector<double>>& values);

// A chamber that is set anew for each row, or a room read once in eight hours, is no noise, and no
// neighbour in time foretells it. What tells it from the thermometer's noise is that the outputs
// follow it. The share of what smoothing took that is to be given back, 0 to 1: 0 where the outputs
// follow it no more than chance does (likelihood ratio of normal noise), else their coefficient of
// what was taken over their coefficient of what was left, as errors in a regressor divide it.
//
// base: rows x columns, without the thermometer's. outputs: rows x outputs. smooth, taken: rows,
// K; smooth + taken is the reading. shapes: rows x shapes, what a temperature may multiply.
double share_followed(const Eigen::MatrixXd& base, const Eigen::MatrixXd& outputs,
                      const Eigen::VectorXd& smooth, const Eigen::VectorXd& taken,
                      const Eigen::MatrixXd& shapes);

}  // namespace driftwise::diagnosis
