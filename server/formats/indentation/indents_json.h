#pragma once
// The table of indents, its fits and its verdict as JSON: `driftwise indent table --json`, and the
// page.

#include <span>
#include <string>

#include "server/indentation/tip_model.h"

namespace driftwise::formats {

std::string indents_json(std::span<const indentation::IndentRow> rows,
                         const indentation::TipReport& report, const indentation::ToolRules& tool);

}  // namespace driftwise::formats
