#pragma once
// Raw polynomial columns from centred, scaled coordinates, exactly.
//
// A variable v (a channel or an effect's output) becomes u = (v - mid) / half, within [-1, 1]; half
// is a power of two and mid a multiple of half / 1024, so that neither step adds error worth
// mention. A raw column such as x^2:t07 is then a known combination of monomials in u (binomial
// expansion), held in extended precision. Regressions run on the monomials, which are well
// conditioned, and are expanded back to the raw columns at the end.

#include <string>
#include <utility>
#include <vector>

#include "server/core/result.h"

namespace driftwise::calibration {

struct Variable {
  std::string name;         // notation: "x", "rate(t07, 300 s)"
  double min = 0, max = 0;  // over the rows of the fit
  double mid = 0, half = 1;
};

// Sets mid and half from min and max. A constant variable gets half 1 and u = 0 throughout.
// Indicators (0 or 1) are kept as they are.
void centre(Variable& variable, bool indicator = false);

using Monomial =
    std::vector<std::pair<int, int>>;  // (variable, exponent > 0), by variable; empty: the constant

struct Expansion {  // raw column = sum of value * monomial
  std::vector<std::pair<int, long double>>
      parts;    // (index of the monomial, value), index ascending
  int top = 0;  // index of the column's own monomial, of the highest degree among its parts
};

struct Basis {
  std::vector<Monomial>
      monomials;  // [0] is the constant; then by degree: parts come before what they are part of
  std::vector<Expansion> expansions;  // one per raw column asked for
};

// columns: the raw columns as monomials in the raw variables. Errors: invalid_argument
// TOO_MANY_TERMS (more than kMostMonomials are needed), BAD_VALUE (a value so large that its powers
// leave double precision).
inline constexpr std::size_t kMostMonomials = 4000;
Result<Basis> make_basis(const std::vector<Variable>& variables,
                         const std::vector<Monomial>& columns);

int degree(const Monomial& monomial);

}  // namespace driftwise::calibration
