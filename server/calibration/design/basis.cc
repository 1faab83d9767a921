#include "server/calibration/design/basis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/core/reasons.h"

namespace driftwise::calibration {
namespace {

long double choose(int n, int k) {
  long double result = 1;
  for (int i = 1; i <= k; ++i) result = result * (n - k + i) / i;
  return result;
}

long double whole_power(long double value, int exponent) {
  long double result = 1;
  for (int i = 0; i < exponent; ++i) result *= value;
  return result;
}

using Parts = std::vector<std::pair<Monomial, long double>>;

// product over variables of (mid + half u)^exponent
Parts expand(const std::vector<Variable>& variables, const Monomial& column, std::size_t limit) {
  Parts parts = {{{}, 1.0L}};
  for (const auto& [index, exponent] : column) {
    const auto& variable = variables[static_cast<std::size_t>(index)];
    Parts next;
    for (int power = 0; power <= exponent; ++power) {
      const long double factor = choose(exponent, power) *
                                 whole_power(variable.mid, exponent - power) *
                                 whole_power(variable.half, power);
      if (factor == 0) continue;
      for (const auto& [monomial, value] : parts) {
        Monomial longer = monomial;
        if (power > 0) longer.emplace_back(index, power);
        next.emplace_back(std::move(longer), value * factor);
      }
      if (next.size() > limit) return next;
    }
    parts = std::move(next);
  }
  return parts;
}

}  // namespace

int degree(const Monomial& monomial) {
  int sum = 0;
  for (const auto& [index, exponent] : monomial) sum += exponent;
  return sum;
}

void centre(Variable& variable, bool indicator) {
  variable.mid = 0;
  variable.half = 1;
  if (indicator) return;
  const double half_range = variable.max / 2 - variable.min / 2;
  if (!(half_range > 0)) {
    variable.mid = variable.min;
    return;
  }
  // No smaller than 1e-301: its reciprocal is finite.
  variable.half = std::max(std::exp2(std::ceil(std::log2(half_range))), 0x1p-1000);
  const double grid = variable.half / 1024;
  const double middle = variable.min / 2 + variable.max / 2;
  const double steps = std::round(middle / grid);
  // With a range far below the value the grid cannot be represented: the middle itself is as good.
  variable.mid = std::abs(steps) < 0x1p52 ? steps * grid : middle;
}

Result<Basis> make_basis(const std::vector<Variable>& variables,
                         const std::vector<Monomial>& columns) {
  const auto too_many = [] {
    return fail(ErrorCode::invalid_argument, reasons::kTooManyTerms,
                "the terms expand to more than " + std::to_string(kMostMonomials) +
                    " products of powers: offer fewer or lower powers");
  };
  std::vector<Parts> expanded;
  expanded.reserve(columns.size());
  const auto by_degree = [](const Monomial& a, const Monomial& b) {
    const int da = degree(a), db = degree(b);
    return da != db ? da < db : a < b;
  };
  std::map<Monomial, int, decltype(by_degree)> index(by_degree);
  index.emplace(Monomial{}, 0);
  for (const auto& column : columns) {
    expanded.push_back(expand(variables, column, kMostMonomials));
    for (const auto& [monomial, value] : expanded.back()) {
      if (!std::isfinite(static_cast<double>(value)))
        return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                    "a term's values leave the range of double precision: use a lower power or "
                    "another unit");
      index.emplace(monomial, 0);
    }
    if (index.size() > kMostMonomials) return too_many();
  }
  Basis basis;
  for (auto& [monomial, position] : index) {
    position = static_cast<int>(basis.monomials.size());
    basis.monomials.push_back(monomial);
  }
  for (std::size_t j = 0; j < columns.size(); ++j) {
    Expansion expansion;
    for (const auto& [monomial, value] : expanded[j])
      expansion.parts.emplace_back(index.at(monomial), value);
    std::sort(expansion.parts.begin(), expansion.parts.end());
    expansion.top = index.at(columns[j]);
    basis.expansions.push_back(std::move(expansion));
  }
  return basis;
}

}  // namespace driftwise::calibration
