#pragma once
// Values of Dataset::excluded. Everything above 0 is kept out of fits.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise {

inline constexpr std::uint8_t kInUse = 0;
inline constexpr std::uint8_t kExcludedRow = 1;  // on somebody's word
// The daemon's mark: the row rests on an instrument or a zero that was found false.
inline constexpr std::uint8_t kSuspectRow = 2;
// The run came by here beside its plan: the zero of a datum, a return to zero of its own, an
// approach from aside, a visit without a point. In the path of effects with memory, a reading of
// nothing.
inline constexpr std::uint8_t kPassageRow = 4;

inline bool is_suspect(const Dataset& dataset, std::size_t row) {
  return !dataset.excluded.empty() && dataset.excluded[row] == kSuspectRow;
}
inline bool is_passage(const Dataset& dataset, std::size_t row) {
  return !dataset.excluded.empty() && dataset.excluded[row] == kPassageRow;
}

// Rows that a mark keeps out, and rows in all: passages are in neither count, for nobody marked
// them and no plan has them.
std::size_t count_kept_out(const Dataset& dataset);
std::size_t count_rows_of_plan(const Dataset& dataset);

// The dataset without the rows that are kept out. For figures over the rows by themselves: effects
// with memory need them.
void leave_excluded_out(Dataset& dataset);
// The same without its passages alone: for rows that are told by their numbers in the plan. Result:
// where each row that is left was.
std::vector<std::size_t> leave_passages_out(Dataset& dataset);
// Position behind the first so many rows that are no passage: what "the first 30 rows" of a person
// ends at, with and without passages in the data. At most dataset.rows.
std::size_t end_of_first_rows(const Dataset& dataset, std::size_t count);

}  // namespace driftwise
