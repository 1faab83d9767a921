#pragma once
// Plans made of blocks: grids visited line by line with a return to zero after each, and scattered
// positions. A block has one set and one force. Pure: the same plan gives the same points, always.

#include <cstdint>
#include <optional>
#include <vector>

#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise {

struct GridRange {  // of one coordinate: from, from + step, ... up to `to`
  double from_mm = 0, to_mm = 0;
  double step_mm = 0;  // not used by scattered points
  // Levels are computed as from + i step, a level within 1e-6 steps of `to` counts. The count is
  // beyond every integer where the step is tiny.
  double count() const;
  std::int64_t levels() const;            // the count of a range of a million levels at most
  double level_mm(std::int64_t i) const;  // rounded to 1e-9 mm: 0.1 * 3 is 0.3
};

struct PlanBlock {
  PointSet set = PointSet::calibration;
  std::vector<GridRange> ranges;  // one per coordinate, in the trajectory's order
  std::optional<double> force_n, dwell_s;
  // A line holds the last coordinate's levels, from the first to the last; then the axes return to
  // zero. These rows belong to the block's set: they are points of its data.
  bool zeros = true;
  // More than 0: so many positions, uniform within the ranges, 1e-4 mm apart from every level of
  // the trajectory's grids so far, in lines of 10 without zero rows.
  std::int64_t scattered = 0;
  std::uint64_t seed = 1;
};

// Lines go on numbering where the trajectory ends. Errors, invalid_argument BAD_PLAN: as many
// ranges as coordinates were expected; a range that runs backwards, a step that is not above 0;
// more than a million points.
Result<void> append_block(Trajectory& trajectory, const PlanBlock& block);

}  // namespace driftwise
