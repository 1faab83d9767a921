#pragma once
// Channels that a run of this cell will have, before it is measured: to judge a formula by. Pure.

#include <string>

#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::application {

// One row of zeros with everything that a point of this cell can have: channels of the cell file
// with the parts of its thermometers, and what its interferometers add to a reading.
Dataset declared_channels(const CellDescription& cell);

// Errors: those of Formula::parse and Formula::expand, such as UNKNOWN_CHANNEL.
Result<void> check_formula_reads(const CellDescription& cell, const std::string& formula);

}  // namespace driftwise::application
