#pragma once
// What a formula offers on a dataset and what of it the rows can tell apart: the fit's own parser,
// design and rank, without the fit. For whoever types a formula and wants to know while typing.

#include "server/application/ports/cell.h"

namespace driftwise::application {

// Pure. Errors: none of the formula's: they are the problem of the answer. The request's runs and
// csv are not looked at: dataset is what they hold.
FormulaCheck check_formula_on(const Dataset& dataset, const FitRequest& request);

}  // namespace driftwise::application
