#pragma once
// A trajectory against the cell: limits of every row, plausibility, duration. Pure.

#include <string>

#include "server/application/trajectories/trajectories.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

// text: the trajectory CSV; name: stands in front of messages; history: what runs of this cell
// took. Errors, invalid_argument: those of read_trajectory_csv; WRONG_COORDINATES (not those of
// this cell); out_of_range: SOFT_LIMIT, naming row, field, value and limit, and how many more rows
// are outside; FORCE_LIMIT; failed_precondition NO_LOAD: a force in a cell that knows none.
// Warnings: rows visited at once again, no validation rows, no return to zero, force confounded
// with time, terms of position that look alike (trajectory_confounding.h).
Result<TrajectoryCheck> check_trajectory_text(const CellDescription& description,
                                              const std::string& name, const std::string& text,
                                              const DurationHistory& history = {});

}  // namespace driftwise::application
