#pragma once
// Rows of run and run_progress. Each call runs inside the caller's transaction and throws
// StorageFailure.

#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Adds a run in the state given. Its request_id must be free.
RunId insert_run(Session& session, const NewRun& run, RunState state);
// The run made for this request before, none when the request is new. Throws already_exists
// REQUEST_ID_REUSED when that run has another trajectory.
std::optional<RunRecord> run_of_request(Session& session, const NewRun& run);

RunRecord read_run(Session& session, RunId run);  // throws not_found NO_SUCH_RUN
void require_run(Session& session, RunId run);    // likewise
[[noreturn]] void throw_no_such_run(Session& session, RunId run);
void change_run_row(Session& session, RunId run, const RunChange& change);

}  // namespace driftwise::storage
