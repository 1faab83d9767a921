#pragma once
// Dataset -> run. Inside a write transaction; throws StorageFailure.

#include "server/core/data/dataset.h"
#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// The rules stand at RunStore::import_dataset. Points keep the file's order; their
// instant is the run's creation plus time_s. trajectory_row counts the rows that are no passages;
// those count on after them, as in a measured run.
RunId import_rows(Session& session, const NewRun& run, const Dataset& dataset);

}  // namespace driftwise::storage
