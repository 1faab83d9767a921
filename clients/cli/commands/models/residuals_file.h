#pragma once
#include <string>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"

namespace driftwise::cli {

// What a model says of every row it was fitted or judged on, as dataset CSV: time, set and place of
// the rows as in the data; then per output what was measured, the model's value (q1_model_mm) and
// the difference measured - model in the summary's unit (q1_residual_nm); empty where a value is
// missing. Throws Failure (bad_input) when the model does not fit the data.
std::string residuals_csv(const Dataset& data, const calibration::Model& model);

}  // namespace driftwise::cli
