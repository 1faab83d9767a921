#include "server/correction/first_conditions.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "server/core/try.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::correction {
namespace {

using effects::Term;

struct Parts {
  Term pose, others;
};

Parts parts_of(const Term& term) {
  Parts parts;
  for (const auto& factor : term.factors) {
    const auto symbols = effects::symbols_of(Term{{factor}});
    const bool of_pose = std::ranges::any_of(symbols, is_pose_symbol);
    (of_pose ? parts.pose : parts.others).factors.push_back(factor);
  }
  return parts;
}

// Nothing: no row has all that it reads, or it reads the clock.
Result<std::optional<double>> first_value(const Dataset& dataset, const Term& term) {
  using Value = std::optional<double>;
  const auto symbols = effects::symbols_of(term);
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create({term}, symbols));
  if (symbols.empty()) return Value();
  std::vector<std::span<const double>> values;
  for (const auto& symbol : symbols) {
    values.push_back(dataset.values_of(symbol));
    if (values.back().empty()) return Value();
  }
  std::vector<double> now(symbols.size()), column(1);
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    for (std::size_t j = 0; j < symbols.size(); ++j) now[j] = values[j][row];
    evaluator.step(dataset.time_s.empty() ? 0.0 : dataset.time_s[row], now, column);
    if (std::isfinite(column.front())) return Value(column.front());
  }
  return Value();
}

}  // namespace

Result<void> count_from_first(const Dataset& dataset, std::vector<Term>& terms,
                              std::vector<double>& mm) {
  const std::size_t given = terms.size();
  for (std::size_t j = 0; j < given; ++j) {
    const Parts parts = parts_of(terms[j]);
    if (parts.pose.factors.empty() || parts.others.factors.empty()) continue;
    DRIFTWISE_TRY(const auto first, first_value(dataset, parts.others));
    if (!first) continue;
    terms.push_back(effects::canonical(parts.pose));
    mm.push_back(-mm[j] * *first);
  }
  return {};
}

}  // namespace driftwise::correction
