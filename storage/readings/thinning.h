#pragma once
// Thinning: raw readings of the environment become one row per device and interval
// (docs/database.md, "Thinning"). Inside the caller's write transaction; throws StorageFailure.

#include <map>
#include <vector>

#include "server/core/records/records.h"
#include "server/core/records/thinning_records.h"
#include "storage/readings/series_block.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Readings of the environment: every value is a temperature, a pressure or a humidity.
inline constexpr std::int64_t kLookedPerStep = 4096;
// Readings that near to an attempt or a datum stay: its temperatures are interpolated from them.
inline constexpr std::int64_t kAroundAttempt_ns = 300'000'000'000;

ThinningStep thin_readings(Session& session, const ThinningOrder& order);

// What stands in the place of thinned readings of a device, by their start; of more than limit the
// newest, 0: all. Within a read.
void read_thinned(Session& session, std::int64_t device, CellTime from, CellTime to, int limit,
                  std::vector<Reading>& into);
// All of it as samples of the series, by channel: for a series that is made again.
std::map<std::int64_t, std::vector<Sample>> thinned_samples(Session& session);

}  // namespace driftwise::storage
