#include "server/diagnosis/answer/lever_limits.h"

#include <cmath>
#include <limits>
#include <string>

namespace driftwise::diagnosis {
namespace {

constexpr double kSigmas = 10;

}  // namespace

std::optional<LeverLimits> declared_lever_limits(const CellDescription& cell) {
  if (!cell.correction) return std::nullopt;
  LeverLimits limits;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t tilt = 0; tilt < 3; ++tilt)
      limits.mm[axis][tilt] = axis == tilt ? 0 : std::numeric_limits<double>::infinity();
  bool any = false;
  for (const auto& beam : cell.correction->beams) {
    if (!(beam.u_offset_mm > 0)) continue;
    const auto axis = std::string("xyz").find(beam.length.symbol.front());
    if (axis == std::string::npos) continue;
    any = true;
    for (std::size_t tilt = 0; tilt < 3; ++tilt)
      if (tilt !=
          axis)  // dx = ry a_z - rz a_y: the component that is neither the axis nor the tilt
        limits.mm[axis][tilt] =
            2 * std::abs(beam.offset_mm[3 - axis - tilt]) + kSigmas * beam.u_offset_mm;
  }
  return any ? std::optional(limits) : std::nullopt;
}

}  // namespace driftwise::diagnosis
