#pragma once
// Fits a model to a dataset: the only path from data to coefficients, for the daemon and the
// command line alike. The same dataset and options give the same model to the last bit, whatever
// the executor.
//
// How: rows with every needed value -> columns in centred, scaled coordinates -> one triangle of
// [1 | X | Y] shared by all outputs (Householder QR, or X'X while that is safe: row_reduction.h)
// -> stepwise selection on the small triangle -> coefficients
// expanded back to the raw columns in extended precision -> statistics, held-out accuracy,
// warnings. NUMERICS.md sections 1 and 2.

#include "server/calibration/model/fit_options.h"
#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::calibration {

// Errors, invalid_argument: BAD_OPTIONS (thresholds, starts, "- 1" with stepwise, hierarchy with a
// forced term whose parent is not offered), UNKNOWN_CHANNEL,
// NO_OUTPUT, UNTIMED (an effect with memory needs time_s), BAD_VALUE (an infinity, with its row and
// column; a weight below 0), TOO_MANY_TERMS; failed_precondition: TOO_FEW_ROWS, SETS_OVERLAP
// (set_overlap.h), RANK_DEFICIENT (Select::all; names every term concerned and what it equals),
// DIGITS_LOST (served_digits.h).
Result<Model> fit(const Dataset& dataset, const FitOptions& options);

}  // namespace driftwise::calibration
