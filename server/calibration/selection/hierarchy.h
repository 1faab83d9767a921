#pragma once
// Hierarchy among terms: a product or a power stands only with its parents (stepwiselm's rule; R's
// marginality). Parents of a term: the term with one factor, or one power, less. x^2:t07 has the
// parents x:t07 and x^2; x and t07 have none but the constant.

#include <string>
#include <vector>

#include "server/effects/term.h"

namespace driftwise::calibration {

std::vector<effects::Term> parents_of(
    const effects::Term& term);  // canonical; without the constant

struct Hierarchy {                                // one entry per term of a design
  std::vector<std::vector<int>> parents;          // indices into the terms
  std::vector<std::vector<std::string>> missing;  // notations of parents that are not offered: the
                                                  // term can never enter
};

Hierarchy hierarchy_of(const std::vector<effects::Term>& terms);

}  // namespace driftwise::calibration
