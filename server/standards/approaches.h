#pragma once
// From which side each row of a dataset came to its position: read off the order of the commands.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::standards {

enum class ApproachSide : std::uint8_t {
  unknown,  // the first row, or one that did not move along this axis
  up,       // towards larger targets: from below
  down      // from above
};

struct Approach {
  double target_mm = 0, measured_mm = 0;
  ApproachSide side = ApproachSide::unknown;
  double time_s = 0;  // 0 when untimed
  bool zero =
      false;  // a return to zero: no position of the test, but where the next row comes from
};

// Which columns of a dataset are what was wanted and what was measured along an axis.
struct AxisColumns {
  std::string axis = "q1";       // a motor coordinate, or x, y, z
  std::string target, measured;  // symbols; empty: found by the axis
};

// Fills in what is empty: measured q1 -> x, q2 -> y, q3 -> z; target x_target (a compensated run's
// wanted pose), goal_x, q1_cmd, in this order.
// Errors: invalid_argument BAD_AXIS; NO_COLUMN when the dataset has none of them.
Result<AxisColumns> find_axis_columns(const Dataset& dataset, AxisColumns asked);

// One entry per row in use in which target and measurement are there, in order of time. A row that
// is kept out, or whose measurement is missing, still is where the next one comes from.
// columns: as find_axis_columns gives them. Errors: those of column_mm.
Result<std::vector<Approach>> approaches_of(const Dataset& dataset, const AxisColumns& columns);

// The visits of one position, in order of time. Two targets are one position when they differ by
// less than 1e-9 mm.
struct Position {
  double target_mm = 0;
  std::vector<Approach> up, down, unknown;
};
// By rising target; returns to zero are left out.
std::vector<Position> positions_of(const std::vector<Approach>& approaches);

}  // namespace driftwise::standards
