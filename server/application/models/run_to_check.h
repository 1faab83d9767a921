#pragma once
// A run that a model was not fitted to, with what it takes to compare the two: the zeros of its
// datums, and of effects with memory what was read before its first row.

#include "server/core/ports/store.h"
#include "server/core/records/records.h"
#include "server/diagnosis/check/check_errors.h"
#include "server/diagnosis/check/check_memory.h"

namespace driftwise::application {

// On the store's thread. An imported run has no known zeros. leaving_out: of the corrections in
// force all but this one are laid over the readings. Errors: those of amended_dataset and of the
// store's reads.
Result<diagnosis::RunToCheck> run_to_check(Store& store, const RunRecord& run,
                                           const diagnosis::ModelMemory& memory,
                                           std::optional<CorrectionId> leaving_out = {});

}  // namespace driftwise::application
