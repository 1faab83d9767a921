#pragma once
// From which side each row of a dataset came to its position: read off the order in which the axis
// was commanded, over the passages too.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::standards {

enum class ApproachSide : std::uint8_t {
  unknown,  // the axis has not moved since the first row
  up,       // towards larger targets: from below
  down      // from above
};

struct Approach {
  double target_mm = 0, measured_mm = 0;
  ApproachSide side = ApproachSide::unknown;
  double time_s = 0;  // 0 when untimed
  // A return to zero: no position of the test, but where the next row comes from.
  bool zero = false;
  bool moved = false;  // since the row before; else the side is that of its last move
};

// Which columns of a dataset are what was wanted and what was measured along an axis.
struct AxisColumns {
  std::string axis = "q1";       // a motor coordinate, or x, y, z; with its robot: ma.q1
  std::string target, measured;  // symbols; empty: found by the axis
};

// Fills in what is empty: measured q1 -> x, q2 -> y, q3 -> z; target x_target (a compensated run's
// wanted pose), goal_x, q1_cmd, in this order; of one of several robots ma.x_target, ma.q1_cmd.
// q1_cmd in data of several robots, as older records have it, is not taken: it may be the command
// of another one.
// Errors: invalid_argument BAD_AXIS; NO_COLUMN when the dataset has none of them.
Result<AxisColumns> find_axis_columns(const Dataset& dataset, AxisColumns asked);

// One entry per row in use in which target and measurement are there, in order of time. A row that
// is kept out, whose measurement is missing, or that is a passage, still is where the next one
// comes from. Sides are those of the axis' own command (q1_cmd); where the dataset has none, of the
// target. A row with the target of the row before stays on the side on which it arrived: what a
// compensation adds at one place is no approach. Where the dataset says overruns, the second of two
// readings at a turn is from the other side.
// columns: as find_axis_columns gives them. Errors: those of column_mm.
Result<std::vector<Approach>> approaches_of(const Dataset& dataset, const AxisColumns& columns);

// The visits of one position, in order of time. Two targets are one position when they differ by
// less than 1e-9 mm.
struct Position {
  double target_mm = 0;
  std::vector<Approach> up, down, unknown;
};
// By rising target; returns to zero are left out, or are positions like any other.
std::vector<Position> positions_of(const std::vector<Approach>& approaches,
                                   bool with_returns = false);

}  // namespace driftwise::standards
