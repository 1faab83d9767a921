#pragma once
// Rows to learn from that a diagnosis needs beyond the terms of its baseline.

#include <cstddef>

namespace driftwise::diagnosis {

inline constexpr std::size_t kRowsBeyondBase = 10;

}  // namespace driftwise::diagnosis
