#include "server/effects/direct_symbols.h"

#include <algorithm>

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::effects {

std::vector<std::string> symbols_read_at_once(const Term& term) {
  Term direct;
  for (const auto& factor : term.factors) {
    const auto* call = std::get_if<Call>(&factor);
    if (call == nullptr || !goes_along_path(*call)) direct.factors.push_back(factor);
  }
  return symbols_of(direct);
}

bool goes_along_path(const Call& call) {
  const auto* kind = find_effect(call.effect);
  return kind != nullptr && kind->observes_path;
}

bool reads_path(const Term& term) {
  return std::ranges::any_of(term.factors, [](const Factor& factor) {
    const auto* call = std::get_if<Call>(&factor);
    return call != nullptr && goes_along_path(*call);
  });
}

}  // namespace driftwise::effects
