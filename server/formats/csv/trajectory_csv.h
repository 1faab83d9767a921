#pragma once
// The trajectory CSV of docs/formats.md: the points to visit, in order. Columns: q1_mm, ... (motor
// coordinates) or x_mm, y_mm, z_mm (a wanted pose), and optionally set, line, zero, force_N,
// dwell_s. Text rules as in dataset_csv.h. Soft limits are the application's business: they belong
// to the cell, not to the file.

#include <string>
#include <string_view>

#include "server/core/trajectory/trajectory.h"

namespace driftwise::formats {

constexpr std::size_t kMostTrajectoryRows = 200'000;  // as of a generated plan; 60 h have 15 000
constexpr double kMostDwell_s = 7 * 86'400.0;

// file_name: stands in front of every message; the file itself is not opened.
// Errors, all invalid_argument, naming file:line, column, found, expected: those of
// read_dataset_csv, and
//   NO_COORDINATES, MIXED_COORDINATES (q and pose), UNKNOWN_COLUMN, MISSING_COORDINATE (empty
//   field), LINE_DECREASES, ZERO_NOT_AT_ZERO (a zero row whose coordinates are not all 0),
//   BAD_DWELL, TOO_MANY_ROWS.
Result<Trajectory> read_trajectory_csv(std::string_view text, const std::string& file_name);

// Writes set, line and zero always; force_N and dwell_s when some point has them.
std::string write_trajectory_csv(const Trajectory& trajectory);

}  // namespace driftwise::formats
