#pragma once
// A data amendment as JSON, schema driftwise.correction.v1: what the table correction keeps. Terms
// stand in the notation of formulas. Keys: docs/formats.md.

#include <string>
#include <string_view>

#include "server/core/result.h"
#include "server/correction/data_amendment.h"

namespace driftwise::formats {

std::string write_amendment_json(const correction::DataAmendment& amendment);

// Errors, invalid_argument: JSON_SYNTAX, BAD_CORRECTION naming the place.
Result<correction::DataAmendment> read_amendment_json(std::string_view text);

}  // namespace driftwise::formats
