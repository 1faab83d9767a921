#include "server/effects/time_constant.h"

#include "server/effects/effect.h"

namespace driftwise::effects {

double tau_s(const Call& call) {
  const EffectKind* kind = find_effect(call.effect);
  const auto known = checked(call);
  if (kind == nullptr || !known) return 0;
  for (std::size_t i = 0; i < kind->parameters.size(); ++i)
    if (kind->parameters[i].name == "tau") return known->parameters[i].value;
  return 0;
}

}  // namespace driftwise::effects
