#pragma once
// A stored model is used only as it was stored. Pure.

#include <string>

#include "server/calibration/model/model.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// Compares the model's content with the hash that was stored with it. Errors: data_loss
// MODEL_DAMAGED naming the model and what to do, also where the store could not read it.
Result<void> check_integrity(const ModelRecord& model);

// The model, for what works on terms alone: residuals, checks, diagnoses, improvements, designs.
// what: "residuals of rows are shown". Errors: those of read_model_json; failed_precondition
// NO_FORMULA (the model has a geometry).
Result<calibration::Model> read_formula_model(const ModelRecord& model, const std::string& what);

}  // namespace driftwise::application
