#pragma once
// Rows of a trajectory as motor coordinates of the whole cell. Pure; for trajectories that
// check_trajectory_limits has accepted.

#include <string>
#include <vector>

#include "server/application/recording/axes_to_move.h"
#include "server/core/description/cell_description.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// Where a row is moved to.
struct RowCommand {
  std::vector<double> q_mm;  // one per axis of the cell
  // Per coordinate of the trajectory, in its unit: what its robot is asked for. Its own value, but
  // for what a serving plan adds to a pose.
  std::vector<double> target;
};

// With one robot all axes. With several those of the robots whose coordinates these are.
AxesToMove axes_moved_by(const CellDescription& cell, const std::vector<Channel>& coordinates);

// Coordinates: motor coordinates in any order, or the pose of a robot with one axis. The result has
// one entry per axis of the cell; axes that are not named are at 0, where every run begins.
std::vector<double> motor_row(const CellDescription& cell, const std::vector<Channel>& coordinates,
                              const std::vector<double>& target);

// Every move of a run that visits the rows one after the other, with its returns to zero, against
// the rules of [[keep_out]]; rows that are queued again are checked when they are moved to. Poses
// are not checked here. Errors: KEEP_OUT (server/application/motion/keep_out.h), naming the row.
Result<void> check_trajectory_keep_out(const CellDescription& cell, const Trajectory& trajectory,
                                       const std::string& name);

}  // namespace driftwise::application
