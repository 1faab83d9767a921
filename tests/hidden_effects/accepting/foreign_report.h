#pragma once
// Summary of a count: what accepting did to the served target, by stratum, the worst first.

#include <string>
#include <vector>

#include "tests/hidden_effects/accepting/foreign_case.h"

namespace driftwise::hidden {

std::string accepting_report(const std::vector<ForeignCase>& cases);

}  // namespace driftwise::hidden
