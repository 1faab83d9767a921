#pragma once
// Rows to learn from that a diagnosis needs beyond the terms of its baseline.

#include <cstddef>

#include "server/core/result.h"

namespace driftwise::diagnosis {

struct Problem;

inline constexpr std::size_t kRowsBeyondBase = 10;

// problem: with its terms, outputs, learn and judge.
// Error: invalid_argument TOO_FEW_ROWS, which says where the other rows are: left out, marked
// validation, without a value of which channel; and what to do.
Result<void> check_rows_needed(const Problem& problem);

}  // namespace driftwise::diagnosis
