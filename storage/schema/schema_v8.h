#pragma once
// Version 8: thinned readings (docs/database.md, "Thinning"). Never edited once released; a later
// change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV8 =
    R"sql(
CREATE TABLE thinning (  -- a stretch of raw readings that became one row per device and interval
  thinning_id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  who TEXT NOT NULL,
  proof TEXT NOT NULL,
  peer TEXT NOT NULL,
  reducer TEXT NOT NULL,     -- mean, min, max
  every_ns INTEGER NOT NULL, -- length of an interval
  first_reading_id INTEGER NOT NULL,
  last_reading_id INTEGER NOT NULL,
  reading_count INTEGER NOT NULL,  -- of the stretch that were removed
  hash BLOB NOT NULL,              -- SHA-256 of their digests, as the entry of the chain has it
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
CREATE TABLE thinned_value (  -- what an interval became
  thinning_id INTEGER NOT NULL REFERENCES thinning (thinning_id),
  device_id INTEGER NOT NULL,
  start_ns INTEGER NOT NULL,  -- of the first reading in it
  channel_id INTEGER NOT NULL,
  end_ns INTEGER NOT NULL,    -- of the last one
  count INTEGER NOT NULL,     -- values of the channel, missing ones left out
  value ANY CHECK (typeof(value) IN ('real', 'null')),  -- NULL: all of them were missing
  PRIMARY KEY (thinning_id, device_id, start_ns, channel_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX thinned_time ON thinned_value (device_id, start_ns);
CREATE INDEX chain_thinned ON chain (entry_id) WHERE what = 'thinned';
)sql";

}  // namespace driftwise::storage
