#pragma once
// Names what cannot be estimated: constant channels, terms that equal combinations of others on
// these rows.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/orthogonal_set.h"

namespace driftwise::calibration {

// "t03 is constant within 0.2 mK" for a term of one variable that hardly moves; "" otherwise.
// Constant: its range is below 1e-7 of its value, or of a temperature below 0.5 mK.
std::string constant_sentence(const Design& design, int term);

// "x^2 and y^2 cannot be told apart on these rows"; "t09 cannot be told apart from t01, t02 on
// these rows": what the term equals of those in the set (a constant may be part of it).
std::string collinear_sentence(const Design& design, const OrthogonalSet& set, int term);

}  // namespace driftwise::calibration
