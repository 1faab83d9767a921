#pragma once
// Positions on a lattice come in tight groups: the places, each as exact as its visits' mean. What
// is tight is told by the data's own range, so a scan over micrometres has places as one over
// millimetres has.

#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

// Values that come in tight groups (gaps below 7e-4 of the range, three visits or more, not wider
// than 2e-3 of it), each group at its mean; the others, and missing ones, as they are.
std::vector<double> by_places(const std::vector<double>& values);

}  // namespace driftwise::diagnosis
