#pragma once
// Runs over one trajectory, measured in different set-ups, joined by trajectory row into one
// dataset (docs/joined-runs.md).
//
// Each pose coordinate comes from the run that measured it; one that several runs measured is their
// mean, and the difference is the check of the join. Zeros are aligned at pose zero. A length is
// corrected by the angles of all runs: what the correction stage of its own cell gives with them
// less what it gave with its own run's. Motor coordinates, temperatures and everything else are the
// mean of the runs that have them; time, line, set and datum are those of the first part.

#include "server/core/result.h"
#include "server/correction/join_part.h"

namespace driftwise::correction {

struct JoinedData {
  Dataset data;                    // metadata: empty
  std::vector<std::int64_t> rows;  // of the trajectory, from 0, that each row of the data is
  JoinReport report;
};

// Of several robots, the runs of one are joined: its id may stand before the symbols.
// Errors: invalid_argument NOTHING_TO_JOIN (less than two parts, no pose coordinate, those of two
// robots, units that differ, one measurement given twice), NO_COMMON_ROWS (less than half of the
// rows are in all parts); those of check_trajectories, check_conditions, check_rows_shifted,
// check_setups_swapped, subtract_returns.
Result<JoinedData> join(JoinParts parts, const JoinRules& rules);

// The robot whose pose was measured; "": none, or channels without an id.
std::string measured_robot(const Dataset& data);

}  // namespace driftwise::correction
