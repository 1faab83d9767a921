#pragma once
// Names what cannot be estimated: constant channels, terms that equal combinations of others on
// these rows.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/design.h"
#include "server/calibration/orthogonal_set.h"

namespace driftwise::calibration {

// "t03 is constant within 0.2 mK" for a term of one variable that hardly moves; "" otherwise.
// Constant: its range is below 1e-7 of its value, or of a temperature below 0.5 mK.
std::string constant_sentence(const Design& design, int term);

// "x^2 cannot be told apart from y^2 on these rows", from those in the set.
std::string collinear_sentence(const Design& design, const OrthogonalSet& set, int term);

}  // namespace driftwise::calibration
