#pragma once
// Accuracy and repeatability of positioning of an axis, after ISO 230-2: five approaches from each
// side to each target position of a linear axis of up to 2000 mm.
//
// With x_ij = measured - target, over the approaches j = 1..5 to the position i, from one side:
//   mean_i, s_i (n - 1 in the divisor); R_i = 4 s_i of the side;
// of both sides: mean_i = (mean_i up + mean_i down) / 2; reversal B_i = mean_i up - mean_i down;
//   R_i = max(2 s_i up + 2 s_i down + |B_i|, R_i up, R_i down).
// Of the axis: B = max |B_i|; E of a side = max mean_i - min mean_i; E over both sides' means;
//   M = max - min of the positions' bidirectional means; R = max R_i;
//   A = max(mean_i + 2 s_i) - min(mean_i - 2 s_i), of a side and over both.
// Sources of the formulas: docs/standards.md. No expansion to 20 degC and no uncertainty of the
// instrument is taken off: the temperatures stand beside.

#include <string>
#include <vector>

#include "server/standards/approaches.h"
#include "server/standards/conditions.h"

namespace driftwise::standards {

struct Iso2302Options {
  AxisColumns columns = {};
  int approaches = 5;  // from each side; the first ones in time when there are more
};

struct Iso2302Side {
  double mean_nm = 0, s_nm = 0, r_nm = 0;
};
struct Iso2302Position {
  double target_mm = 0;
  Iso2302Side up, down;
  double mean_nm = 0, reversal_nm = 0, r_nm = 0;
};

// One value per way of looking at the axis.
struct Iso2302Triple {
  double both_nm = 0, up_nm = 0, down_nm = 0;
};

struct Iso2302 {
  AxisColumns columns;
  int approaches = 5;
  std::vector<Iso2302Position> positions;  // by rising target
  std::vector<double> turning_points_mm;   // targets beyond them, approached from one side only
  Iso2302Triple a, r, e;                   // accuracy, repeatability, systematic deviation
  double m_nm = 0;                         // range of the mean bidirectional deviations
  double b_nm = 0, mean_b_nm = 0;          // largest and mean reversal
  Conditions conditions;
  std::vector<std::string> warnings;
};

// Errors: those of find_axis_columns and column_mm; failed_precondition, saying what is missing:
//   LACKS_APPROACHES (which position has how many from which side), TOO_FEW_POSITIONS (fewer than
//   five, or than five per metre).
// Positions outside those that were approached from both sides (more than once) are where the axis
// turned round: they belong to no figure and stand in turning_points_mm.
Result<Iso2302> iso230_2(const Dataset& dataset, const Iso2302Options& options);

}  // namespace driftwise::standards
