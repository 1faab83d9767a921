#pragma once
// Held-out accuracy by contiguous blocks of time: each block is predicted by a model that was
// selected and fitted without it and without a gap of rows on either side (random folds leak
// through autocorrelation, NUMERICS.md section 3).

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/report/held_out_figure.h"
#include "server/calibration/selection/stepwise.h"

namespace driftwise::calibration {

// Where the pieces of a RowReduction must end so that blocks can be held out: begin, head, tail of
// every block, then the number of rows. Empty: too few rows, or no blocks asked for.
std::vector<Eigen::Index> block_cuts(const Design& design, int blocks, double gap);

struct BlockOutcome {  // of one output; column unit
  HeldOut figure;
  std::vector<double> errors;  // one per row of the design, in its order; NaN: not judged
};

// Why there is no figure, where a block leaves too few rows to fit: a clause naming it.
using BlockResult = tl::expected<BlockOutcome, std::string>;

// Per output. Blocks have equal numbers of rows. Terms that the rows outside a block do not
// determine are left out there, in the order of the terms.
// reduction: of the design, cut by block_cuts(), so that a fold costs width^3 and one pass over the
// rows it left out. Rows of a datum that is not in the training: judge_untrained().
std::vector<BlockResult> held_out_by_blocks(const Design& design, const RowReduction& reduction,
                                            const SelectionRule& rule, const Executor& executor);

}  // namespace driftwise::calibration
