#pragma once
// What must hold after a kill. Reads the database with the sqlite3 library alone, not with our
// store.

#include <cstdint>
#include <string>

#include "tests/faults/acknowledged_points.h"
#include "tests/support/running_cell.h"
#include "tests/support/sql_query.h"

namespace driftwise::tests {

// Lines of per_line rows, each beginning with its return to zero.
std::string crash_trajectory(int lines, int per_line);

// A run as the kill left it on the disk; run_id 0: it did not get there.
struct LeftBehind {
  std::int64_t run_id = 0, points = 0, datums = 0;
  std::string state;
  bool has_begun() const { return state == "running" || state == "waiting"; }
};
LeftBehind left_behind(const std::string& database);

// The run is done, what was acknowledged is there unchanged, nothing is there twice, the file is
// sound.
void expect_nothing_lost(RunningCell& cell, const v1::Run& run, const PointsByRow& acknowledged);

// If the one kill met the run under way: its record says so, with the attempt that was interrupted,
// and the new datum holds the comparison of its zero with the one before.
void expect_restart_recorded(RunningCell& cell, const v1::Run& run, const LeftBehind& before);

}  // namespace driftwise::tests
