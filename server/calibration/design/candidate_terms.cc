#include "server/calibration/design/candidate_terms.h"

#include <algorithm>
#include <unordered_set>

#include "server/effects/term_order.h"

namespace driftwise::calibration {

OfferedTerms offered_terms(const FitOptions& options, const std::vector<int>& datums) {
  OfferedTerms offered;
  std::unordered_set<std::string> seen, forced, excluded;
  for (const auto& term : options.forced) forced.insert(effects::notation(term));
  for (const auto& term : options.excluded) excluded.insert(effects::notation(term));
  const auto reads_excluded = [&options](const effects::Term& term) {
    const auto symbols = effects::symbols_of(term);
    return std::ranges::any_of(options.exclude_channels, [&symbols](const std::string& symbol) {
      return std::ranges::find(symbols, symbol) != symbols.end();
    });
  };
  const auto add = [&](const effects::Term& term, bool always) {
    const std::string text = effects::notation(term);
    if (!seen.insert(text).second) return;
    offered.terms.push_back(effects::canonical(term));
    offered.always.push_back(always ? 1 : 0);
  };
  if (options.candidates.constant) {
    add({}, true);
    for (std::size_t i = 1; i < datums.size(); ++i) add(effects::datum_term(datums[i]), true);
  }
  for (const auto& term : options.candidates.terms) {
    const std::string text = effects::notation(term);
    const bool is_forced = forced.contains(text);
    if (!is_forced && (excluded.contains(text) || reads_excluded(term))) continue;
    add(term, is_forced);
  }
  for (const auto& term : options.forced) add(term, true);
  return offered;
}

}  // namespace driftwise::calibration
