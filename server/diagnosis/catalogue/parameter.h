#pragma once
// The unknown parameter of a cause: from the grid's cell to its best value, its interval and the
// curve of its likelihood.

#include <functional>
#include <optional>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"

namespace driftwise::diagnosis {

// Growth of 2 ln L with the effect at this value of its parameter.
using GainOf = std::function<double(double value)>;

struct Refined {
  double value = 0, gain = 0;
};

// Golden-section search between the neighbours of the start on the cause's grid. Instants: each of
// them between those neighbours. Degrees and causes without a parameter: the start.
// instants: between neighbouring rows, ascending.
Refined refine(const Cause& cause, double start, const std::vector<double>& instants,
               const GainOf& gain);

// The value as it is written in a term: six significant digits, and as many more as the search
// tells apart between the neighbours on the cause's grid. "313.436 nm", not "313.43600293706527".
// Instants, degrees and causes without a parameter: the value.
double as_written(const Cause& cause, double value);

struct Profile {
  Interval ci90;
  std::vector<CurvePoint> curve;
};

// To either side until the gain has dropped by 2.71 (times the scale), the 90 % point of
// chi-squared with one degree of freedom; an end that the grid's range cuts off stays there. The
// curve goes as far as a drop of about 10. None for degrees and causes without a parameter.
std::optional<Profile> profile(const Cause& cause, const Refined& at,
                               const std::vector<double>& instants, const GainOf& gain);

}  // namespace driftwise::diagnosis
