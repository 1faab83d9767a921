#pragma once
// Dataset -> run. Inside a write transaction; throws StorageFailure.

#include "server/core/data/dataset.h"
#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// The rules stand at RunStore::import_dataset. Points keep the file's order as their
// trajectory_row; their instant is the run's creation plus time_s.
RunId import_rows(Session& session, const NewRun& run, const Dataset& dataset);

}  // namespace driftwise::storage
