#pragma once

#include <vector>

#include "server/application/provenance/data_questions.h"
#include "server/core/cell_time.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

// Facts on record about the runs that a model is fitted from; one that goes on counts until
// fitted. Errors: not_found NO_SUCH_RUN; those of RunStore::dataset. Called on the store's thread.
Result<std::vector<DataOfModel>> data_of_model(Store& store, const std::vector<RunId>& runs,
                                               CellTime fitted);

}  // namespace driftwise::application
