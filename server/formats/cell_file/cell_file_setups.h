#pragma once
// [[setup]] of a cell file: named choices of instruments.

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// After the devices: each coordinate of a set-up is one that its device gives. Refused:
// MISSING_KEY, DUPLICATE_ID, DUPLICATE_CHANNEL, BAD_SETUP (no coordinate; a device that is none of
// the cell's, measures no pose or does not give the coordinate; a scale of 0; an empty range).
void read_setup(TomlReader&& reader, const std::string& place, CellDescription& out,
                TomlProblem& problem);

}  // namespace driftwise::formats
