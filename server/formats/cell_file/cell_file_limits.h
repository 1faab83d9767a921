#pragma once
// [plausibility] and [[limit]] of a cell file (docs/cell-file.md).

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

void read_plausibility(TomlReader&& reader, PlausibilityRules& out);
// A channel may be any that a device of the cell gives; two limits of one channel are refused.
void read_limit(TomlReader&& reader, PlausibilityRules& out);

}  // namespace driftwise::formats
