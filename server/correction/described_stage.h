#pragma once

#include "server/core/description/cell_description.h"
#include "server/correction/correction.h"

namespace driftwise::correction {

// The stage that a cell file describes.
Stage stage_from(const CorrectionDescription& description);

}  // namespace driftwise::correction
