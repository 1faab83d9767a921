#pragma once
// The noise between the shapes of a grid. A search over causes may take the nearest of
// noise_grid(): one effect is asked of it at a time. A test for what is left may not: of five
// thousand rows the correlation of neighbours is known to a hundredth, and the grid misses it by
// more.

#include <functional>
#include <vector>

#include "server/diagnosis/noise/ground.h"

namespace driftwise::diagnosis {

// One shape per output, ratio and correlation time as near to the likeliest as the data tell (0.5
// in 2 ln L). grid: noise_grid() of the timeline, on_grid: of it. Stopped by tick: what is known
// by then.
std::vector<NoiseShape> shapes_between(const Timeline& timeline,
                                       const std::vector<NoiseShape>& grid, const Ground& on_grid,
                                       const SoftBase& base, const Eigen::MatrixXd& series,
                                       const std::function<bool()>& tick);

}  // namespace driftwise::diagnosis
