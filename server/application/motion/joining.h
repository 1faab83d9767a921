#pragma once
// The slow channels that belong to an instant, by the devices' own time stamps.
//
// A temperature is that of the nearest scan, as a rule the last one before the instant: waiting for
// the next one would take up to a scan period per point, and a structure moves by millikelvins
// within it. Where the scan after is there already, it is interpolated. A force is measured while
// the axes stand at the place, or not at all.

#include <optional>
#include <vector>

#include "server/application/motion/workbench.h"
#include "server/application/recording/channel_history.h"

namespace driftwise::application {

// Every temperature of the cell (required), then what joins_when_fresh() (where it is fresh
// enough). at_rest: since when the axes stand where they are; forces of before do not join, and
// without it none does. Errors, failed_precondition: CHANNEL_MISSING, CHANNEL_TOO_OLD, naming the
// first temperature that fails.
Result<std::vector<ChannelValue>> join_slow_channels(const CellDescription& description,
                                                     const ChannelHistory& history,
                                                     CellTime instant, double max_age_s,
                                                     std::optional<CellTime> at_rest = {});

// As above, at rest since RunScope::at_rest. A force of which no reading began since then is read
// now. A temperature that is too old waits for the next scan: one that comes within the maximum age
// after the instant still joins. Errors besides: aborted, cancelled.
Awaitable<Result<std::vector<ChannelValue>>> join_when_scanned(RunScope& scope, CellTime instant);

}  // namespace driftwise::application
