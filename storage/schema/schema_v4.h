#pragma once
// Version 4: what those who watch need. Alarms, kept trajectories, summaries of the readings, and
// the database's own name. Never edited once released; a change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV4 =
    R"sql(
CREATE TABLE database_identity (  -- one row: tells a cursor of this database from one of another
  one INTEGER PRIMARY KEY CHECK (one = 1),
  id TEXT NOT NULL
) STRICT;
INSERT INTO database_identity (one, id) VALUES (1, lower(hex(randomblob(8))));

CREATE TABLE alarm (  -- what asked for a person
  alarm_id INTEGER PRIMARY KEY,
  level TEXT NOT NULL CHECK (level IN ('notice', 'warning', 'failed')),
  kind TEXT NOT NULL,               -- dotted and stable: device.lost
  subject TEXT NOT NULL,            -- laser-x
  message TEXT NOT NULL,
  since_ns INTEGER NOT NULL,
  cleared_ns INTEGER NOT NULL,      -- 0: it still holds
  acknowledged_ns INTEGER NOT NULL, -- 0: nobody has
  acknowledged_by TEXT NOT NULL,
  change INTEGER NOT NULL UNIQUE,   -- numbers the changes of all alarms; of the last one of this alarm
  )sql" DRIFTWISE_UTC_COLUMN("since") R"sql(
) STRICT;
CREATE INDEX alarm_standing ON alarm (alarm_id) WHERE cleared_ns = 0 OR acknowledged_ns = 0;

CREATE TABLE trajectory (  -- kept for later; a text once kept never changes
  trajectory_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  text TEXT NOT NULL,
  hash TEXT NOT NULL UNIQUE,  -- of the text
  row_count INTEGER NOT NULL,
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(
) STRICT;

-- Made from reading and reading_value, and made again from them if both tables are emptied: plots of a
-- long run read these instead. The bytes are explained in storage/readings/series_block.h.
CREATE TABLE series_block (
  block_id INTEGER PRIMARY KEY,
  channel_id INTEGER NOT NULL,
  level INTEGER NOT NULL,     -- 0: values with their instants; above: minima, maxima, sums and counts
  start_ns INTEGER NOT NULL,
  data BLOB NOT NULL
) STRICT;
CREATE UNIQUE INDEX series_block_place ON series_block (channel_id, level, start_ns);
CREATE TABLE series_mark (  -- one row: readings up to this one are in series_block
  one INTEGER PRIMARY KEY CHECK (one = 1),
  reading_id INTEGER NOT NULL
) STRICT;
INSERT INTO series_mark (one, reading_id) VALUES (1, 0);
)sql";

}  // namespace driftwise::storage
