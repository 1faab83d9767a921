#pragma once
// The table of indents and what it tells, for people and for programs.

#include <vector>

#include "clients/cli/core/console.h"
#include "server/indentation/tip_model.h"

namespace driftwise::cli {

void print_indents(const Console& console, const std::vector<indentation::IndentRow>& rows,
                   const indentation::TipReport& report, const indentation::ToolRules& tool);

}  // namespace driftwise::cli
