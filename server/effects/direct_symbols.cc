#include "server/effects/direct_symbols.h"

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::effects {

std::vector<std::string> symbols_read_at_once(const Term& term) {
  Term direct;
  for (const auto& factor : term.factors) {
    const auto* call = std::get_if<Call>(&factor);
    const auto* kind = call == nullptr ? nullptr : find_effect(call->effect);
    if (kind == nullptr || !kind->observes_path) direct.factors.push_back(factor);
  }
  return symbols_of(direct);
}

}  // namespace driftwise::effects
