#pragma once
// How a run's state gets to disk, and how a run that was under way is taken up again.

#include <string>
#include <string_view>

#include "server/application/runs/active_run.h"
#include "server/application/runs/run_engine.h"

namespace driftwise::application {

// A run that stands in the store with this reason was left in good order.
constexpr std::string_view kShutDownReason =
    "the daemon was shut down; it goes on with the next start";

// The run stands for this stop, and has not begun or gone on yet.
void pause_by_stop(RunRecord& record, const RunHold& stop);

// Writes state, reason, times, lag and restarts of the run's record. No refusal of the database
// ends a run: the end of a run is written again until it is on record or the daemon ends; any other
// state is shown meanwhile (ActiveRun::state_unstored) and written with the next change, or by the
// pause that it is. While a stop is in force, a run that is not
// over is stored as paused by it, also before the engine has come to the stop.
Awaitable<Result<void>> store_state(ActiveRun& run);

// Until the run's control changes. A state that is not on record yet is written meanwhile, as soon
// as it fits: a pause that is not there would be over after a kill.
Awaitable<Result<void>> wait_for_change(ActiveRun& run);

// The daemon ends while a pause, a stop or a trouble waits for the end of the point under way: the
// record's state and hold become theirs. What ends by itself, a condition or a question about the
// cell file, leaves a run that waits.
void adopt_pause(ActiveRun& run);

// After a kill: the row that was under way, or was about to be, gets an attempt on record as
// interrupted.
Awaitable<Result<void>> record_interruption(ActiveRun& run);

// The datum to open after a restart: homed anew, compared with the newest datum by that datum's own
// returns to zero.
DatumOpening continue_from(const CellDescription& description, std::string reason,
                           const RunBefore& before);

}  // namespace driftwise::application
