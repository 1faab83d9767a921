#pragma once
// Rows of a run beside its plan: every place that its axes reached and no point stands for. The
// zero of a datum, a return of its own, an approach from aside, a visit that was given up, a place
// where a movement was stopped or that a person moved the axes to. They show the path that the
// robot took, and are a reading of nothing (kPassageRow).

#include <vector>

#include "server/application/runs/active_run.h"

namespace driftwise::application {

// Those that wait, but for the newest one, as rows of the present datum: the axes stand there, and
// a point may come to stand for it.
std::vector<PointRecord> passages_behind(const ActiveRun& run);
// They are on disk; a point that is stands for the newest one too.
void drop_passages(ActiveRun& run, std::size_t stored, bool has_point);

// The newest one was read: values are the motors' coordinates, the pose and what joins.
void note_passage_read(ActiveRun& run, const std::vector<ChannelValue>& values, Stamp measured);

// The axes rest where no movement of the run ended as commanded: it was stopped on its way, or a
// person moved them. What stands where the run knows of is no row, nor what cannot be asked.
Awaitable<void> note_stand(ActiveRun& run);

// The axes stand at the zero of the present datum, wherever they came from: homing moves them too.
// Where the way to a run's first row began is its first datum.
void note_zeroing(ActiveRun& run);

// All that wait, on disk when it returns; a full disk keeps the run waiting. Errors: the store's,
// aborted, cancelled.
Awaitable<Result<void>> store_passages(ActiveRun& run);

}  // namespace driftwise::application
