#pragma once
// The mapping file (TOML) of docs/import.md: text -> ImportMapping.

#include <string>
#include <string_view>

#include "server/formats/import/import_mapping.h"

namespace driftwise::formats {

// file_name: stands in front of every message; nothing is opened.
// Errors, invalid_argument, each naming file:line, table, key, found and expected: BAD_TOML,
// MISSING_KEY, UNKNOWN_KEY, WRONG_TYPE, OUT_OF_RANGE, BAD_CHANNEL, DUPLICATE_CHANNEL, UNKNOWN_UNIT,
// UNIT_KIND, BAD_TIME_FORMAT, NO_COLUMNS, NOT_A_ROTATION, BAD_RULE.
Result<ImportMapping> read_import_mapping(std::string_view text, const std::string& file_name);

}  // namespace driftwise::formats
