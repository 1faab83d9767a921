#pragma once
// The slow channels that belong to an instant, by the devices' own time stamps.

#include <vector>

#include "server/application/motion/workbench.h"
#include "server/application/recording/channel_history.h"

namespace driftwise::application {

// Every temperature of the cell (required), then what joins_when_fresh() (where it is fresh
// enough). Errors, failed_precondition: CHANNEL_MISSING, CHANNEL_TOO_OLD, naming the first
// temperature that fails.
Result<std::vector<ChannelValue>> join_slow_channels(const CellDescription& description,
                                                     const ChannelHistory& history,
                                                     CellTime instant, double max_age_s);

// As above, but a temperature that is too old waits for the next scan: one that comes within the
// maximum age after the instant still joins.
Awaitable<Result<std::vector<ChannelValue>>> join_when_scanned(RunScope& scope, CellTime instant);

}  // namespace driftwise::application
