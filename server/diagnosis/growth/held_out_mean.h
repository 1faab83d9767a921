#pragma once
// The mean error of the held-out rows, tested: a verdict that looked at spreads only would call a
// simulation adequate that misses every held-out row by the same amount.
//
// Test, per output: z = mean / sd, with
//   sd^2 = w^2 sum(d_i^2) / n^2 + s^2 mean(d_i)^2 + (w^2 + s^2 k) sum(d_j^2 h_j^2),
//   h = X (X' X)^-1 c,
// w and s the white and slow standard deviations of the noise, d the spread of a row's noise over
// the others' (Problem::row_sd), i of the n held-out rows, j of the learning rows, k the rows
// within two correlation times, X the learning rows' columns, c the mean of the held-out rows'
// columns. The slow noise is not averaged, so that the test errs to the side of silence.

#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

class Extension;

// Means that noise alone makes less often than alpha, corrected for the number of outputs.
// outputs: as outputs_of() gives. Of an output that was freed of rounding errors or of sides
// (ProblemOutput::freed_of) the mean is that of the freed values.
std::vector<LeftOver> means_beyond_noise(const Problem& problem,
                                         const std::vector<OutputSummary>& outputs,
                                         const Extension& extension, double alpha);

}  // namespace driftwise::diagnosis
