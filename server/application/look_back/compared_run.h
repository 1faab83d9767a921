#pragma once
// Series of a run for its comparison with others. Pure.

#include "server/application/look_back/look_back.h"
#include "server/application/models/models.h"
#include "server/core/data/dataset.h"

namespace driftwise::application {

// Returns to zero in nm or arcsec, temperatures in K, both as changes since the first value.
void add_measured(const Dataset& data, ComparedRun& out);
// Residuals as they are, in their summary unit.
void add_residuals(const ModelResiduals& residuals, ComparedRun& out);

}  // namespace driftwise::application
