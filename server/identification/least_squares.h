#pragma once
// Nonlinear least squares by Levenberg and Marquardt: the library cminpack, behind a function.
// Source: J. J. More, The Levenberg-Marquardt algorithm, Lecture Notes in Mathematics 630 (1978);
// MINPACK's lmder. Why this library: docs/decisions/0006-cminpack.md.

#include <Eigen/Core>
#include <functional>
#include <string>

#include "server/core/result.h"

namespace driftwise::identification {

struct LeastSquaresProblem {
  // The residuals at some values, and their derivatives (residuals x values). Same sizes at every
  // call; the number of residuals is at least that of the values. NaN: not to be reached, the step
  // is taken back.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> jacobian;
};

struct LeastSquaresSolution {
  Eigen::VectorXd values;
  double sum_of_squares = 0;
  int evaluations = 0;
};

// The nearest minimum downhill from start. The values should be scaled so that 1 is a sensible
// step. Errors: failed_precondition TOO_FEW_ROWS, BAD_START (residuals at the start are not
// numbers), NO_CONVERGENCE (how far it came).
Result<LeastSquaresSolution> minimise(const LeastSquaresProblem& problem,
                                      const Eigen::VectorXd& start, int most_evaluations = 300);

}  // namespace driftwise::identification
