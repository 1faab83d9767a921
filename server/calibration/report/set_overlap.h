#pragma once
// Calibration and validation rows that are one measurement written twice.

#include "server/calibration/design/design.h"

namespace driftwise::calibration {

// A validation row that agrees with a calibration row in every channel, to the last bit, was not
// held out. Errors: failed_precondition SETS_OVERLAP, with how many there are and the first pair.
// Rows kept out of the fit do not count. Cost: one pass, nothing where there is one set only.
Result<void> check_sets_apart(const Dataset& dataset, const Design& design);

}  // namespace driftwise::calibration
