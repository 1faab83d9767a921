#pragma once
// Turns that no row shows. Where ISO 230-2 has a target read once from either side, the axis goes
// past it between the two readings; the file has the same place twice in succession and the way on
// is back. "# overruns: yes" at the head of a dataset says that it was measured so.

#include <cstddef>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise {

inline constexpr const char* kOverruns = "overruns";  // key of the metadata

bool says_overruns(const Dataset& dataset);

// Rows that repeat the place of the row before, all motor coordinates and poses alike, between a
// move and one back: ascending.
std::vector<std::size_t> rows_after_overruns(const Dataset& dataset);

// With a row before each of those, at the same instant: the coordinate that turns stands further on
// by half of its smallest move. With one before the first row too, where it stands as far short of
// it. For effects that go along the path; kept: where the rows are now.
struct WholePath {
  Dataset data;
  std::vector<std::size_t> kept;
};
WholePath with_overruns(const Dataset& dataset);

}  // namespace driftwise
