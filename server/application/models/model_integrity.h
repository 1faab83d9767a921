#pragma once
// A stored model is used only as it was stored. Pure.

#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// Compares the model's content with the hash that was stored with it. Errors: data_loss
// MODEL_DAMAGED naming the model and what to do, also where the store could not read it.
Result<void> check_integrity(const ModelRecord& model);

}  // namespace driftwise::application
