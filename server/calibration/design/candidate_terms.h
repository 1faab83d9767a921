#pragma once
// Which terms a fit offers: the formula's candidates, less those excluded, plus those forced, datum
// constants in front.

#include <vector>

#include "server/calibration/model/fit_options.h"

namespace driftwise::calibration {

struct OfferedTerms {
  std::vector<effects::Term>
      terms;  // canonical, each once: the constant, datum constants, candidates
  std::vector<char> always;
};

// datums: ordinals that occur in the rows that are fitted, ascending; the first has the model's own
// constant. Without a constant there are no datum constants either: "- 1" means through the zero of
// every datum.
OfferedTerms offered_terms(const FitOptions& options, const std::vector<int>& datums);

}  // namespace driftwise::calibration
