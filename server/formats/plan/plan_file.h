#pragma once
// plan.toml: the text of a serving plan (docs/plans.md).

#include <string>
#include <string_view>

#include "server/core/result.h"
#include "server/plans/serving_plan.h"

namespace driftwise::formats {

constexpr std::size_t kMostPlanBytes = 64 * 1024;

// Errors, invalid_argument, with file and line: TOML_SYNTAX, UNKNOWN_KEY, MISSING_KEY, WRONG_TYPE,
// OUT_OF_RANGE, BAD_PLAN (a robot that is not there, a robot without or with two models, a band
// that does not widen), DUPLICATE_ID, BAD_CHANNEL, TOO_LONG.
Result<plans::ServingPlan> read_plan_file(std::string_view text, const std::string& file_name);

std::string plan_hash(std::string_view text);  // SHA-256, 64 digits

}  // namespace driftwise::formats
