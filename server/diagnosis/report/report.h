#pragma once
// From what a search found to what a diagnosis says.

#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/growth/extension.h"

namespace driftwise::diagnosis {

// Numbers, intervals, held-out gain and sentence of each of the named.
std::vector<Finding> findings_of(const Problem& problem, const std::vector<Cause>& causes,
                                 const Extension& extension);

// Figures and residuals of every output, before and after the extension.
std::vector<OutputSummary> outputs_of(const Problem& problem, const Dataset& dataset,
                                      const Extension& extension);

// The baseline with the findings' terms, each once.
std::string extended_formula(const std::string& baseline, const std::vector<Finding>& findings);

}  // namespace driftwise::diagnosis
