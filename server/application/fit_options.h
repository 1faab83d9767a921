#pragma once
// What a client asks of a fit, as the options of one: the daemon's fit of a run and the command
// line's fit of a file then differ in nothing. Pure.

#include "server/application/cell.h"
#include "server/calibration/fit.h"

namespace driftwise::application {

// Without the formula's candidates. source: for the lineage. Errors: invalid_argument BAD_OPTIONS
// (select, criterion), and those of formats::parse_term.
Result<calibration::FitOptions> fit_options_from(const FitRequest& request, const Dataset& dataset,
                                                 const std::string& source);

}  // namespace driftwise::application
