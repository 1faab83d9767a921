#pragma once
// [[hold]] of a cell file (docs/holds.md).

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// After the devices: the channels of a rule must be among theirs.
void read_hold(TomlReader&& reader, CellDescription& out);
// Each stabiliser's distance from its set-point against [checks] stabiliser_band_k, as the rule
// "stabiliser-<id>"; a rule of that name in the file stands in its place.
void add_holds_of_stabilisers(CellDescription& out);

}  // namespace driftwise::formats
