#pragma once
// A block of a plan as `trajectory grid --block` spells it:
//   "calibration 0:2.5:0.5 force=2.305 dwell=15"
//   "validation q1=0:1:0.1 q2=0:0:1 q3=0:0:1 zeros=no"
//   "validation 0.1:2.4 scattered=94 seed=7 force=0.392"

#include <string>
#include <vector>

#include "server/core/channel.h"
#include "server/core/result.h"
#include "server/core/trajectory/trajectory_grid.h"

namespace driftwise::cli {

// Errors, invalid_argument BAD_BLOCK: the word that was not understood and what was expected.
Result<PlanBlock> plan_block_from(const std::string& text, const std::vector<Channel>& coordinates);

// "q1,q2,q3", or "ma.q1,ma.q2" in a cell of several robots -> channels in mm. Errors,
// invalid_argument: BAD_CHANNEL.
Result<std::vector<Channel>> coordinates_from(const std::string& text);

}  // namespace driftwise::cli
