#pragma once
// Three causes at once that a robot may well have together, no two of which are known look-alikes.

#include <vector>

#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise::hidden {

// Twenty sets, of what `all` has of each cause. Throws std::out_of_range when one is missing.
std::vector<std::vector<Hidden>> triples_of(const std::vector<Hidden>& all);

}  // namespace driftwise::hidden
