#pragma once
// [[hold]] of a cell file (docs/holds.md).

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// Names of all channels that the devices of the cell read: those they are there for, and what they
// tell beside (an interferometer's air temperature, signal level and scatter, a stabiliser's
// set-point). Sorted. After the devices.
std::vector<std::string> channels_read(const CellDescription& cell);
// Refuses a channel that is none of these names: NO_SUCH_CHANNEL, naming them all.
void check_is_read(TomlReader& reader, const char* key, const std::string& channel,
                   const std::vector<std::string>& names);

// After the devices: the channels of a rule must be among theirs.
void read_hold(TomlReader&& reader, CellDescription& out);
// Each stabiliser's distance from its set-point against [checks] stabiliser_band_k, as the rule
// "stabiliser-<id>"; a rule of that name in the file stands in its place.
void add_holds_of_stabilisers(CellDescription& out);

}  // namespace driftwise::formats
