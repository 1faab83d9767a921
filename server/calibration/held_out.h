#pragma once
// Held-out accuracy by contiguous blocks of time: each block is predicted by a model that was
// selected and fitted without it and without a gap of rows on either side (random folds leak
// through autocorrelation, NUMERICS.md section 3).

#include <optional>

#include "server/calibration/design.h"
#include "server/calibration/stepwise.h"

namespace driftwise::calibration {

struct HeldOut {
  double u90 = 0;            // 1.645 x root mean square of the errors of all blocks; column unit
  double low = 0, high = 0;  // 90 %: jackknife over the blocks on the logarithm of the mean square,
                             // t with blocks - 1
};

// Per output; none where a block leaves too few rows to fit. Blocks have equal numbers of rows.
// Only triangles of segments are kept, so the cost over one fit is small. Rows of a datum that is
// not in the training are judged about their mean.
std::vector<std::optional<HeldOut>> held_out_by_blocks(const Design& design,
                                                       const SelectionRule& rule, int blocks,
                                                       double gap, const Executor& executor);

}  // namespace driftwise::calibration
