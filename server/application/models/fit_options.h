#pragma once
// What a client asks of a fit, as the options of one: the daemon's fit of a run and the command
// line's fit of a file then differ in nothing. Pure: a fit runs on the worker's thread.

#include "server/application/models/fit_request.h"
#include "server/calibration/fit.h"
#include "server/core/records/records.h"

namespace driftwise::application {

// Without the formula's candidates. source: for the lineage. Errors: invalid_argument BAD_OPTIONS
// (select, criterion), and those of formats::parse_term.
Result<calibration::FitOptions> fit_options_from(const FitRequest& request, const Dataset& dataset,
                                                 const std::string& source);

// From data and wishes to the record of a model; who made it and when is left open. Errors: as
// above, and those of formats::fit_formula.
Result<ModelRecord> fit_record(const Dataset& dataset, const FitRequest& request,
                               const std::string& source);

// "runs 3, 4"; "dataset" for a file.
std::string source_of(const FitRequest& request);

}  // namespace driftwise::application
