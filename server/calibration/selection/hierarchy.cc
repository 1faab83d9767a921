#include "server/calibration/selection/hierarchy.h"

#include <algorithm>
#include <unordered_map>

#include "server/effects/term_order.h"

namespace driftwise::calibration {

using effects::Term;

std::vector<Term> parents_of(const Term& term) {
  const Term whole = effects::canonical(term);
  std::vector<Term> parents;
  for (std::size_t i = 0; i < whole.factors.size(); ++i) {
    Term parent = whole;
    const auto at = parent.factors.begin() + static_cast<std::ptrdiff_t>(i);
    if (auto* power = std::get_if<effects::Power>(&*at); power != nullptr && power->exponent > 1)
      --power->exponent;
    else
      parent.factors.erase(at);
    if (!parent.is_constant() && std::ranges::find(parents, parent) == parents.end())
      parents.push_back(std::move(parent));
  }
  return parents;
}

Hierarchy hierarchy_of(const std::vector<Term>& terms) {
  std::unordered_map<std::string, int> index;
  for (std::size_t j = 0; j < terms.size(); ++j)
    index.emplace(effects::notation(terms[j]), static_cast<int>(j));
  Hierarchy hierarchy;
  hierarchy.parents.resize(terms.size());
  hierarchy.missing.resize(terms.size());
  for (std::size_t j = 0; j < terms.size(); ++j) {
    if (effects::datum_of(terms[j])) continue;
    for (const auto& parent : parents_of(terms[j])) {
      const std::string name = effects::notation(parent);
      const auto at = index.find(name);
      if (at == index.end())
        hierarchy.missing[j].push_back(name);
      else
        hierarchy.parents[j].push_back(at->second);
    }
  }
  return hierarchy;
}

}  // namespace driftwise::calibration
