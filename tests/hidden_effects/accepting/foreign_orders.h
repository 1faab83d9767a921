#pragma once
// Data sets of a count on the independent population, in the mix of foreign/judge.py's size
// `paired`: nothing hidden 120, singles at chi2 75 and 150 two of each cause, pairs 28, in no
// catalogue 36. Spread so that a count that ends early is balanced too.

#include <cstdint>
#include <vector>

#include "tests/hidden_effects/foreign/generate.h"

namespace driftwise::hidden {

struct NumberedOrder {
  int number = 0;  // from 0; the seed is seed_base + number
  foreign::Order order;
};

// rounds: so many times the mix, the causes of pairs going on. In study units.
std::vector<NumberedOrder> paired_orders(std::uint64_t seed_base, int rounds);

}  // namespace driftwise::hidden
