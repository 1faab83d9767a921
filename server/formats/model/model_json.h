#pragma once
// A model as JSON, schema driftwise.model.v1: everything that calibration::Model holds, exact both
// ways. Terms stand as their factors (and as notation, for people), so that no formula parser is
// needed to read them back. Keys: docs/formats.md.

#include <string>
#include <string_view>

#include "server/calibration/model/model.h"
#include "server/core/result.h"

namespace driftwise::formats {

// indent < 0: one line. The same model gives the same text: its hash identifies it.
std::string write_model_json(const calibration::Model& model, int indent = -1);

// Identifies what was fitted: the hash of the text without fit_us, so that the same fit elsewhere
// has the same one.
// The same of a model's JSON as it is stored, without reading it as a model: equal to model_hash()
// of the model that it was written from, as long as nothing in it has changed. Errors: BAD_MODEL
// (no JSON).
// stored: the hash that stands beside it, whose form the answer has; empty: the present form.
Result<std::string> stored_model_hash(std::string_view json, std::string_view stored = {});
std::string model_hash(const calibration::Model& model);

// Errors, invalid_argument: JSON_SYNTAX (with line and column), BAD_MODEL naming the place
// ("outputs[0].covariance"), what was found and what was expected. Sizes are checked against one
// another; every number must be finite.
Result<calibration::Model> read_model_json(std::string_view text);

}  // namespace driftwise::formats
