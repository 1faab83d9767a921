#pragma once

#include <vector>

namespace driftwise::application {

// Axes of the cell that a motion is for, in the order of CellDescription::axes(). The others stay
// where they are.
struct AxesToMove {
  std::vector<bool> named;  // empty: all
  bool contains(std::size_t axis) const {
    return named.empty() || (axis < named.size() && named[axis]);
  }
};

}  // namespace driftwise::application
