#pragma once
// Rows of a dataset by their numbers in the trajectory, counted from 1. The n-th row of a file is
// row n of its trajectory unless the run left a row out or measured one later than its neighbours.
// Then the line of metadata "trajectory_rows: 1-11,13-21,12" names them in the order of the file.
// Passages are no rows of the trajectory.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::formats {

constexpr std::string_view kTrajectoryRowsKey = "trajectory_rows";

// One number per row that is no passage: by the line, else 1, 2, 3...
// Errors: invalid_argument BAD_ROWS (the line is none of this form, or names another number of rows
// than the dataset has: rows were taken out of the file or put in).
Result<std::vector<std::int64_t>> trajectory_rows(const Dataset& dataset,
                                                  const std::string& file_name);

// The line for these numbers, in place of the dataset's; no line where they are 1, 2, 3...
void set_trajectory_rows(Dataset& dataset, const std::vector<std::int64_t>& rows);

}  // namespace driftwise::formats
