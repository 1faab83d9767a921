#pragma once
// [[certificate]]: certificates of instruments.

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// out: with its devices.
void read_certificate(TomlReader&& reader, CellDescription& out);

}  // namespace driftwise::formats
