#pragma once
// Formula checks and residuals: domain -> proto.

#include "driftwise/v1/model_service.pb.h"
#include "server/application/models/models.h"

namespace driftwise::rpc {

// With every effect that a formula may hold, for completion.
v1::CheckFormulaResponse formula_check_from(const application::FormulaCheck& check);

// Every row_step-th row, so that an answer holds 400 000 numbers at most.
v1::ListResidualsResponse residuals_from(const application::ModelResiduals& residuals);

}  // namespace driftwise::rpc
