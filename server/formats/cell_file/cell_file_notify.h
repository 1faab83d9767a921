#pragma once
// [[notify]], [watchdog] and [[channel_alarm]] of cell.toml.

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// Call it when the devices are known. Refused: BAD_RECEIVER (not exactly one of webhook, smtp and
// command; another scheme; a key of another kind of receiver), NEEDS_TLS (a secret over a plain
// connection that leaves the computer), BAD_TIME (hours), BAD_LIMITS, DUPLICATE_ID, MISSING_KEY,
// BAD_CHANNEL.
void read_notify(TomlReader& top, CellDescription& out, TomlProblem& problem);

}  // namespace driftwise::formats
