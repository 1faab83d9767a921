#pragma once
// The simulated cells that coverage is counted on, by name.

#include <functional>
#include <string>
#include <vector>

#include "tests/statistics/served_case.h"

namespace driftwise::statistics {

std::vector<std::string> case_names();
std::function<SimulatedCase(std::uint64_t seed)> case_named(const std::string& name);

}  // namespace driftwise::statistics
