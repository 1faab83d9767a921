#pragma once
// [correction] and [load] of cell.toml.

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

void read_load(TomlReader&& load, LoadDescription& out);

// Call it when the devices are known: what corrects a length must be measured in this cell. A beam
// names a length that a device gives, each once; a corrected length needs the two rotations about
// the other axes. Refused: BAD_CHANNEL, DUPLICATE_CHANNEL, MISSING_KEY.
void read_correction(TomlReader&& correction, CellDescription& out, TomlProblem& problem);

// A text with a [correction] section: a whole cell.toml whose other sections are passed over, or
// that section alone, for offline work. Which device gives a length is not checked. Errors,
// invalid_argument with file_name:line: TOML_SYNTAX, MISSING_KEY, those of read_correction.
Result<CorrectionDescription> parse_correction_file(std::string_view text,
                                                    const std::string& file_name);

}  // namespace driftwise::formats
