#pragma once
// Thinning: raw readings of the environment become one row per device and interval
// (docs/database.md, "Thinning"). Inside the caller's write transaction; throws StorageFailure.

#include <map>
#include <vector>

#include "server/core/records/records.h"
#include "server/core/records/thinning_records.h"
#include "storage/readings/kept_stretches.h"
#include "storage/readings/series_block.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Readings of the environment: every value is a temperature, a pressure or a humidity.
inline constexpr std::int64_t kLookedPerStep = 4096;

// kept: goes from step to step of one order; the first step, with no after_id, begins it anew.
ThinningStep thin_readings(Session& session, const ThinningOrder& order, KeptStretches& kept);

// What stands in the place of thinned readings of a device, by their start; of more than limit the
// newest, 0: all. Within a read.
void read_thinned(Session& session, std::int64_t device, CellTime from, CellTime to, int limit,
                  std::vector<Reading>& into);
// All of it as samples of the series, by channel: for a series that is made again.
std::map<std::int64_t, std::vector<Sample>> thinned_samples(Session& session);

}  // namespace driftwise::storage
