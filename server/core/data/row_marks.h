#pragma once
// Values of Dataset::excluded. Everything above 0 is kept out of fits.

#include <cstdint>

#include "server/core/data/dataset.h"

namespace driftwise {

inline constexpr std::uint8_t kInUse = 0;
inline constexpr std::uint8_t kExcludedRow = 1;  // on somebody's word
// The daemon's mark: the row rests on an instrument or a zero that was found false.
inline constexpr std::uint8_t kSuspectRow = 2;

inline bool is_suspect(const Dataset& dataset, std::size_t row) {
  return !dataset.excluded.empty() && dataset.excluded[row] == kSuspectRow;
}

// The dataset without the rows that are kept out. For figures over the rows by themselves: effects
// with memory need them.
void leave_excluded_out(Dataset& dataset);

}  // namespace driftwise
