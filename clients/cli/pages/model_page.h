#pragma once
// A model as a page that can be signed: what was fitted to what, every term with its figures, the
// accuracy, the warnings.

#include <vector>

#include "clients/cli/core/console.h"
#include "driftwise/v1/model_service.pb.h"

namespace driftwise::cli {

// The page a metrologist signs: cell, data, instruments and what is declared of them, the model
// term by term, its accuracy, the budget of a target in the middle and at a corner, what it warns
// of.
void print_model_page(const Console& console, const v1::GetModelResponse& shown);
void print_models(const Console& console, const std::vector<v1::Model>& models);
void print_comparison(const Console& console, const v1::CompareModelsResponse& comparison);

}  // namespace driftwise::cli
