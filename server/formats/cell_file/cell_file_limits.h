#pragma once
// [plausibility] and [[limit]] of a cell file (docs/cell-file.md).

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

void read_plausibility(TomlReader&& reader, PlausibilityRules& out);
// After the devices: a channel may be any that one of them reads; two limits of one channel are
// refused.
void read_limit(TomlReader&& reader, const std::vector<std::string>& channels,
                PlausibilityRules& out);

}  // namespace driftwise::formats
