#pragma once
// The model that an accepted diagnosis makes: its baseline with the terms that it found, each in
// the outputs that show it by themselves. A term in every output would have a size by chance in the
// others. Pure.

#include "server/application/diagnoses/extension_plan.h"
#include "server/application/models/fit_request.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// data: with the plan in force. request: how the baseline is fitted; its formula is not read. A
// baseline whose terms these data cannot hold apart is selected stepwise, with the terms that were
// found in. Errors: those of fit_options_from and calibration::fit_placed.
Result<ModelRecord> fit_extension(const ExtensionPlan& plan, const Dataset& data,
                                  FitRequest request);

}  // namespace driftwise::application
