#include "tests/hidden_effects/shapes/counted_cases.h"

#include <iostream>

namespace driftwise::hidden {

CountedCases counted(const SweepPlan& plan) {
  constexpr int kFewNulls = 99;
  CountedCases sum;
  for (const auto& one : cases_of(plan)) {
    const auto outcome = judged(one.world, one.hidden, one.seed, kFewNulls, false);
    const auto count = [](Rate& rate, bool hit) { rate.hits += hit ? 1 : 0, ++rate.sets; };
    count(sum.in_set, outcome.exact_or_set);
    count(sum.false_name, outcome.false_names > 0);
    if (!outcome.exact)
      std::cout << one.key << ": " << (outcome.named.empty() ? outcome.note : outcome.named)
                << "\n";
  }
  return sum;
}

}  // namespace driftwise::hidden
