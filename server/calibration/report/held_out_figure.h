#pragma once
// Figures of merit from the errors of rows that were held out fold by fold.

#include <vector>

#include "server/core/data/accuracy.h"

namespace driftwise::calibration {

struct HeldOut {                     // column unit
  ErrorFigures figures;              // of the errors of all folds together
  double low = 0, high = 0;          // 90 % interval of A90: jackknife over the folds on the
                                     // logarithm of the mean square, t with folds - 1
  double u90_low = 0, u90_high = 0;  // of U90, likewise on the variance
  int folds = 0;
};

// At least two folds.
HeldOut held_out_figure(const std::vector<ErrorSums>& folds);

}  // namespace driftwise::calibration
