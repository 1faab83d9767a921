#pragma once
// [access] of cell.toml.

#include "server/core/description/access_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// A section that is there configures access. Refused: BAD_ADDRESS; NEEDS_TLS (a door without
// certificate and key, or one of the two alone); MISSING_KEY.
void read_access(TomlReader&& access, AccessDescription& out);

}  // namespace driftwise::formats
