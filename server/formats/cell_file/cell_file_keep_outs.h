#pragma once
// [[keep_out]] of a cell file: distances that robots keep from each other.

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// After the robots are complete. Refused: MISSING_KEY, DUPLICATE_ID (two rules of one name),
// DUPLICATE_CHANNEL, BAD_KEEP_OUT (an axis that no robot has, axes of one robot only, a share of 0,
// a distance at the zero that is below the smallest one: every run begins there).
void read_keep_out(TomlReader&& reader, const std::string& place, CellDescription& out,
                   TomlProblem& problem);

}  // namespace driftwise::formats
