#pragma once
// The mean error of the held-out rows, tested: a verdict that looked at spreads only would call a
// simulation adequate that misses every held-out row by the same amount.
//
// Test, per output: z = mean / sd, with
//   sd^2 = w^2 / n + s^2 + (w^2 + s^2 k) c' (X' X)^-1 c,
// w and s the white and slow standard deviations of the noise, n the held-out rows, k the rows
// within two correlation times, X the learning rows' columns, c the mean of the held-out rows'
// columns. The slow noise is not averaged, so that the test errs to the side of silence.

#include <Eigen/Core>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Means that noise alone makes less often than alpha, corrected for the number of outputs.
// columns: of the extended simulation, every row of the dataset. outputs: as outputs_of() gives.
std::vector<LeftOver> means_beyond_noise(const Problem& problem,
                                         const std::vector<OutputSummary>& outputs,
                                         const Eigen::MatrixXd& columns, double alpha);

}  // namespace driftwise::diagnosis
