#pragma once
// Runs -> dataset. Inside a read transaction; throws StorageFailure.

#include <span>

#include "server/core/data/dataset.h"
#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// The rules stand at RunStore::dataset. runs: at least one, each once: else invalid_argument
// BAD_RUNS. Runs in units that differ: invalid_argument UNITS_DISAGREE; files that state one thing
// in two ways: METADATA_DISAGREE.
Dataset read_dataset(Session& session, std::span<const RunId> runs);

}  // namespace driftwise::storage
