#pragma once
// How far from the centre of rotation a beam can meet its mirror, by what the cell declares: what
// tilts do beyond that is not the beam's but the robot's.

#include <array>
#include <optional>

#include "server/core/description/cell_description.h"

namespace driftwise::diagnosis {

struct LeverLimits {
  // [pose axis x y z][rotation rx ry rz], mm that the true lever may differ from the corrected one.
  // Infinite where the cell declares nothing, 0 for the rotation about the beam itself.
  std::array<std::array<double, 3>, 3> mm;
};

// A component a of a beam's offset with standard uncertainty u can be wrong by 2 |a| + 10 u: its
// sign, or forgotten altogether, and then some. Nothing: no beam of the cell declares an
// uncertainty.
std::optional<LeverLimits> declared_lever_limits(const CellDescription& cell);

}  // namespace driftwise::diagnosis
