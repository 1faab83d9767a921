#pragma once
// Rows of wanted poses of several robots as motor coordinates of the whole cell, by a serving plan.
// Pure; any thread.

#include <string>

#include "server/application/trajectories/motor_rows.h"
#include "server/plans/joint_snapshot.h"

namespace driftwise::application {

// One row. Every robot of the plan needs a coordinate among these, else it would have to move
// without a row that names it. target: the wanted pose with what the plan's steps add, which is
// what each robot is asked for. Beyond soft limits is no error here: whoever moves there checks
// them. Errors: those of plans::joint_name and plans::joint_refusal_error; invalid_argument
// MISSING_COORDINATE (a robot without coordinates), failed_precondition NOT_ALL_AXES.
Result<RowCommand> joint_row(const CellDescription& cell, const plans::JointSnapshot& plan,
                             const std::vector<Channel>& coordinates, const TrajectoryPoint& row,
                             CellTime now);

// Every row of a run before it begins: it has a target, within the soft limits, and the moves keep
// the distances of [[keep_out]]. Under the conditions of the snapshot: each row is worked out anew
// when it is moved to. name: stands in front of messages. Errors: those of joint_row, naming the
// row; out_of_range SOFT_LIMIT; KEEP_OUT.
Result<void> check_joint_rows(const CellDescription& cell, const plans::JointSnapshot& plan,
                              const Trajectory& trajectory, const std::string& name, CellTime now);

}  // namespace driftwise::application
