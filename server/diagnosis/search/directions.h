#pragma once
// The directions in which one amplitude shows in several outputs: an error of one motor, or of the
// instrument that measures one coordinate, is in every output by the robot's own slopes.

#include <optional>
#include <vector>

#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/coordinate_frame.h"

namespace driftwise::diagnosis {

// The pose coordinates and the motors, in the order of the outputs and then of the data. In a frame
// the motors by its mean slopes; else what is no output by the least-squares plane of the outputs
// over all of these that vary. Without several outputs none; none of those that the data do not
// move independently.
std::vector<Direction> directions_of(const Problem& problem,
                                     const std::optional<CoordinateFrame>& frame);

}  // namespace driftwise::diagnosis
