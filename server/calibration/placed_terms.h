#pragma once
// A fit with terms that belong to some of the outputs only: what a diagnosis found in one motor is
// no law of the others, where a free fit would give it a size by chance.

#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::calibration {

struct PlacedTerm {
  effects::Term term;
  std::vector<std::string> outputs;  // that have it: "q1"
  // A change that stays, such as a step in the data's own time: it is fitted, and then its value at
  // the last row of the fit is added to the constant and the term is left out of the model.
  bool stays = false;
};

// As fit(). A placed term that options.candidates has is fitted in its own outputs alone; a placed
// term that it has not changes nothing.
Result<Model> fit(const Dataset& dataset, const FitOptions& options,
                  const std::vector<PlacedTerm>& placed);

// The model of the formula of options with the placed terms joined to it: always in where they
// belong. A term that the formula has already stays in every output. formula: as the model shows
// it. Errors: those of fit().
Result<Model> fit_placed(const Dataset& dataset, FitOptions options, std::vector<PlacedTerm> placed,
                         const std::string& formula);

}  // namespace driftwise::calibration
