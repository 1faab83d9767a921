#pragma once
// One visit of a trajectory row: attempts until the point is accepted, queued again or given up,
// each on record.

#include <functional>

#include "server/application/runs/active_run.h"
#include "server/application/runs/trajectory_walk.h"

namespace driftwise::application {

// Worked out right before the move: the row's own motor coordinates, or the target for its pose.
using CommandFor = std::function<Result<RowCommand>(const ActiveRun&, const TrajectoryPoint&)>;

struct VisitResult {
  Verdict verdict = Verdict::accepted;
  std::optional<PointRecord> point;
};

// The point and the run's place are on disk when this returns; the run's record in memory has moved
// along. A full disk keeps the run waiting here and loses nothing. After an error (device, control)
// the attempt under way is on record as interrupted, the place is where it was.
Awaitable<Result<VisitResult>> visit_row(ActiveRun& run, Visit visit,
                                         const CommandFor& command_for);

// Commits until it is stored; while the disk is full the run waits. Errors: what the store says
// else, aborted, cancelled.
Awaitable<Result<std::optional<PointId>>> commit_until_stored(RunScope& scope, PointCommit commit);

}  // namespace driftwise::application
