#pragma once
// Rows as people name them: "12,40-45".

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::formats {

// Ascending, each once, both ends of a range included. At most kMostRows of them.
// Errors: invalid_argument BAD_ROWS, with the piece that was found.
constexpr std::size_t kMostRows = 1'000'000;
Result<std::vector<std::int64_t>> parse_row_ranges(std::string_view text);

// The shortest text that reads back as the same rows; rows: ascending, each once.
std::string row_ranges_text(const std::vector<std::int64_t>& rows);
// For a sentence: its first ten ranges, "1,3,5-9 and 40 more (49 rows)".
std::string row_ranges_told(const std::vector<std::int64_t>& rows);

// Which rows of a dataset are excluded, as content_hash of their row_ranges_text (rows counted from
// 0 over the dataset); "" when none is. Passages are part of a run and count as none. A file and
// the runs that it was exported from agree.
std::string exclusions_hash(const Dataset& dataset);

}  // namespace driftwise::formats
