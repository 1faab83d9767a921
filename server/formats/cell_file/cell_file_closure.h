#pragma once
// [closure] and [[closure_limit]] of a cell file (docs/cell-file.md).

#include "server/core/description/cell_description.h"
#include "server/core/description/closure_rules.h"

namespace driftwise::formats {

class TomlReader;
struct TomlProblem;

// cell: its devices are read already. Two limits of one channel, and one of a channel that is no
// length or rotation of the cell, are refused.
ClosureRules read_closure(TomlReader& top, const CellDescription& cell, TomlProblem& problem);

// As the text of the cell file has them; without a text the defaults.
ClosureRules closure_rules_of(const CellDescription& cell);

}  // namespace driftwise::formats
