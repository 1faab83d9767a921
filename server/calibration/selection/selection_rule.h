#pragma once
// From the options of a fit to the rule of its selection.

#include "server/calibration/design/design.h"
#include "server/calibration/selection/stepwise.h"

namespace driftwise::calibration {

// What can be said of the options without data. Errors: invalid_argument BAD_OPTIONS.
Result<void> check_options(const FitOptions& options);

// With hierarchy the parents of what is always in become always in as well (design.always), and a
// term with a parent that is not offered is barred. Errors: invalid_argument BAD_OPTIONS, where a
// term that must be in (forced; select all) has such a parent.
Result<SelectionRule> selection_rule(const FitOptions& options, Design& design);

// "hierarchy: x:t01 needs t01, which is not offered: it cannot enter", one per barred term.
std::vector<std::string> barred_sentences(const Design& design, const SelectionRule& rule);

}  // namespace driftwise::calibration
