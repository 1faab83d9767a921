#pragma once
// What every request is checked for before the cell hears of it.

#include <google/protobuf/repeated_field.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/ids.h"
#include "server/core/result.h"
#include "server/core/text/clean_text.h"

namespace driftwise::rpc {

// Identifiers count from 1. Errors: invalid_argument, BAD_ID, naming the field.
Result<void> check_id(std::int64_t id, std::string_view field);

// A cursor counts from 0. Errors: invalid_argument, BAD_CURSOR.
Result<void> check_cursor(std::int64_t cursor, std::string_view field);

// 0 means the usual number. Errors: invalid_argument, BAD_LIMIT (negative or above most).
Result<int> limit_from(std::int32_t limit, int usual, int most);

// Errors: invalid_argument, TOO_LONG, naming the field and the size found.
Result<void> check_size(std::string_view text, std::size_t most_bytes, std::string_view field);

// One line of text for people, as it is stored: a name, a reason. Control characters are replaced
// (core/clean_text.h). Errors: TOO_LONG.
Result<std::string> line_from(std::string_view text, std::size_t most_bytes,
                              std::string_view field);

// Runs of a request. Errors: BAD_ID; TOO_MANY_RUNS (more than 1000); DUPLICATE_RUN.
Result<std::vector<RunId>> run_ids_from(const google::protobuf::RepeatedField<std::int64_t>& ids);

// Sizes: a name or a note is for people, a trajectory of 60 h has about 15 000 rows.
constexpr std::size_t kMostNameBytes = 256;
constexpr std::size_t kMostNoteBytes = 16 * 1024;
constexpr std::size_t kMostRequestIdBytes = 128;
constexpr std::size_t kMostFormulaBytes = 16 * 1024;
constexpr std::size_t kMostTrajectoryBytes = 8 * 1024 * 1024;
constexpr std::size_t kMostDatasetBytes = 32 * 1024 * 1024;

}  // namespace driftwise::rpc
