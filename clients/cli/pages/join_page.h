#pragma once
// The report of a join of runs (driftwise.join.v1) for people.

#include <nlohmann/json.hpp>
#include <ostream>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

void print_join(std::ostream& out, const Paint& paint, const nlohmann::ordered_json& report);

}  // namespace driftwise::cli
