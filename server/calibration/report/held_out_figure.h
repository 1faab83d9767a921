#pragma once
// Figures of merit from the errors of rows that were held out fold by fold.

#include <Eigen/Core>
#include <set>
#include <span>
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

// Errors of rows whose datum is not among those trained, so that its constant was not to be known:
// about the mean of each such datum, which takes one of its m degrees of freedom, and so times
// sqrt(m / (m - 1)). One row alone is all mean and says nothing: NaN. datums: of each row.
void judge_untrained(std::span<const int> datums, const std::set<int>& trained,
                     Eigen::Ref<Eigen::VectorXd> errors);

// At least two folds.
HeldOut held_out_figure(const std::vector<ErrorSums>& folds);

}  // namespace driftwise::calibration
