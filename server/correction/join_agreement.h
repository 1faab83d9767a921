#pragma once
// Whether runs may be joined at all: one trajectory, one tool, one zero pose, one thermal state.

#include "server/core/result.h"
#include "server/correction/join_part.h"

namespace driftwise::correction {

// Rows are named as people count them, from 1. Errors: failed_precondition TRAJECTORIES_DIFFER.
Result<void> check_trajectories(const JoinParts& parts, const JoinRules& rules);

// Fills in the report's differences and warnings. Errors: failed_precondition TOOLS_DIFFER,
// TEMPERATURES_DIFFER, ZEROS_DIFFER; invalid_argument NO_POSE_ZERO.
Result<void> check_conditions(const JoinParts& parts, const JoinRules& rules, JoinReport& report);

// Rows of the data in which the robot is at pose zero: returns to zero; a file without any: rows
// whose motor coordinates are all within the rules' distance of 0.
std::vector<std::size_t> rows_at_zero(const JoinPart& part, const JoinRules& rules);

}  // namespace driftwise::correction
