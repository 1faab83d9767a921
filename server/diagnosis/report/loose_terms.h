#pragma once
// Terms of the baseline that its plan hardly determines: of an axis with four levels, the fourth
// power. On the rows of the fit they do no harm; on other places their coefficients' uncertainty is
// in every prediction, and what a finding gains or spoils there is not to be seen beside it.

#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// From the plan alone, without what was measured. Of a prediction on the held-out rows, rms over
// them, in standard deviations of the noise: what the coefficients of the fit are uncertain by.
struct LooseTerms {
  double with = 0, without = 0;    // with all terms; without those named
  std::vector<std::string> terms;  // in the notation of formulas, the loosest first
};

// Nothing where the coefficients add less than the noise itself, or fewer than 20 rows are held
// out.
std::optional<LooseTerms> loose_terms(const Problem& problem);
std::string sentence(const LooseTerms& loose);

}  // namespace driftwise::diagnosis
