#pragma once
// What a cause's linear coefficients mean: the numbers of the catalogue.

#include <string>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"

namespace driftwise::diagnosis {

struct LinearNumber {
  std::string name;   // "nm_per_k"; "" where the catalogue has none for this coefficient
  double factor = 1;  // number = factor x coefficient in nm per unit of the term
};

bool is_square(const effects::Term& term);  // of one channel, and nothing else

// Of an output that is a length. term: one of the finding's, at its best parameter.
LinearNumber linear_number(LinearParameter parameter, const effects::Term& term, double value);
// Of an output in arcsec: number = factor x coefficient in arcsec per unit of the term.
LinearNumber linear_number_of_angle(LinearParameter parameter, const effects::Term& term,
                                    double value);

}  // namespace driftwise::diagnosis
