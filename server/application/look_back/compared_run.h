#pragma once
// Series of a run for its comparison with others. Pure.

#include "server/application/look_back/look_back.h"
#include "server/application/models/models.h"
#include "server/core/data/dataset.h"

namespace driftwise::application {

// Returns to zero in nm or arcsec, temperatures in K, whatever the units of the channels, both as
// changes since the first value. With one axis and one length a return is the length against the
// axis' own reading, as the run judged it (closure_nm in motion/datum_opening.h); datums: those of
// the run.
void add_measured(const Dataset& data, std::span<const DatumRecord> datums, ComparedRun& out);
// Residuals as they are, in their summary unit.
void add_residuals(const ModelResiduals& residuals, ComparedRun& out);

}  // namespace driftwise::application
