#pragma once
// A trajectory against the soft limits of the cell, before anything moves. Pure.

#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// Motor coordinates are held against their axes. With several robots a trajectory moves any of
// them, each by all its axes, or has poses of them. Poses: with one axis x is its motor
// coordinate; with several, the cell's nominal [kinematics] says which motor coordinates a pose
// needs (the compensated ones differ by micrometres, and every move is checked again). The result
// is a warning when nothing could be checked, for the cell has no kinematics; else empty. name:
// stands in front of messages. Errors: invalid_argument WRONG_COORDINATES (not those of this cell);
// out_of_range SOFT_LIMIT, naming row, field, value and limit, and how many more values are
// outside.
Result<std::string> check_trajectory_limits(const CellDescription& description,
                                            const Trajectory& trajectory, const std::string& name);

}  // namespace driftwise::application
