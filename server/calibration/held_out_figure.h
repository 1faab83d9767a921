#pragma once
// One figure of merit from the errors of rows that were held out fold by fold.

#include <vector>

namespace driftwise::calibration {

struct HeldOut {
  double u90 = 0;            // 1.645 x root mean square of the errors of all folds; column unit
  double low = 0, high = 0;  // 90 %: jackknife over the folds on the logarithm of the mean square,
                             // t with folds - 1
};

struct FoldSquares {  // of the errors of one fold
  double squares = 0, rows = 0;
};

// At least two folds.
HeldOut held_out_figure(const std::vector<FoldSquares>& folds);

}  // namespace driftwise::calibration
