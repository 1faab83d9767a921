#pragma once
// Groups of neighbouring places, to be left out together.

#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

// The largest group is cut at the middle of its longest side until there are `count`. places:
// coordinates scaled alike, one size. Indices of places.
std::vector<std::vector<std::size_t>> neighbouring_groups(
    const std::vector<std::vector<double>>& places, std::size_t count);

}  // namespace driftwise::diagnosis
