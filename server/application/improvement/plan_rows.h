#pragma once
// Length of a plan against the formula that its rows are to be explained by, before anything moves.
// Pure.

#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// A diagnosis learns from the calibration rows; in a plan without validation rows a fifth of them
// is held out. It needs the baseline's terms and 10 rows more (diagnosis::kRowsBeyondBase).
// Errors: invalid_argument TOO_FEW_ROWS, with both numbers; those of check_formula_reads
// (server/application/datasets/declared_channels.h).
Result<void> check_plan_rows(const CellDescription& cell, const Trajectory& plan,
                             const std::string& formula);

}  // namespace driftwise::application
