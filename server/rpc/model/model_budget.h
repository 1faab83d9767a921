#pragma once
// What a model's page says beyond the model: the cell's declared uncertainties, and the budget it
// would state at the middle and at a corner of its domain.

#include "driftwise/v1/model_service.pb.h"
#include "server/calibration/model/model.h"
#include "server/core/description/cell_description.h"

namespace driftwise::rpc {

// Temperatures in the middle of their fitted ranges, the model's own datum. The corner is where
// every coordinate is at the upper end of its range. A model that cannot serve targets has no
// budget: nothing is added.
void add_budgets(const calibration::Model& model, const CellDescription& cell,
                 v1::GetModelResponse& out);

// Every uncertainty that the cell file declares and that is not 0, in the file's order.
void add_declared(const CellDescription& cell, v1::GetModelResponse& out);

}  // namespace driftwise::rpc
