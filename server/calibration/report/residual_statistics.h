#pragma once
// Figures from residuals: spread, autocorrelation, pure error.

#include <Eigen/Core>
#include <optional>

#include "server/calibration/design/design.h"

namespace driftwise::calibration {

// Of successive residuals in time order; 0 below three values. Effective rows: n (1 - r) / (1 + r),
// within 1..n: how many independent rows carry as much about a mean as these (first-order
// autoregression; Bayley and Hammersley 1946).
double lag1_autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& residuals);
double effective_rows(std::int64_t rows, double lag1);

struct PureError {
  double sd = 0;  // of one row about repeats of it
  int dof = 0;
  bool exact =
      false;  // the repeats agree in every variable: classical, a lack-of-fit test may use it
};

// From rows that repeat one another. Where rows agree exactly in every variable of the design: the
// spread of y within those groups. Else, since temperatures never repeat: rows that visit the same
// pose again (each pose channel within 0.1 % of its range), and half the mean squared difference of
// their residuals from one visit to the next (von Neumann), which leaves slow drift out. None: no
// pose is visited again, or the rows are weighted.
std::optional<PureError> pure_error(const Design& design, Eigen::Index output,
                                    const Eigen::VectorXd& residuals);

}  // namespace driftwise::calibration
