#pragma once
// Version 10: what leaves the machine. Receivers, what they were told of each alarm, and alarms
// that are shelved. Never edited once released; a later change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV10 =
    R"sql(
CREATE TABLE receiver (  -- [[notify]] of the cell file
  name TEXT PRIMARY KEY,
  known_since_ns INTEGER NOT NULL  -- what was over before is not told
) STRICT, WITHOUT ROWID;

CREATE TABLE telling (  -- what one receiver knows of one alarm; an alarm without a row is still to be told
  alarm_id INTEGER NOT NULL REFERENCES alarm (alarm_id),
  receiver TEXT NOT NULL,
  firing_ns INTEGER NOT NULL,    -- when it was told that the alarm stands; 0: not yet
  last_ns INTEGER NOT NULL,      -- when it was last told so
  resolved_ns INTEGER NOT NULL,  -- when it was told that the alarm is over; 0: not yet
  count INTEGER NOT NULL,        -- messages that arrived
  failed INTEGER NOT NULL,       -- tries since the last one that arrived
  tried_ns INTEGER NOT NULL,
  error TEXT NOT NULL,           -- of the last try; empty: it arrived
  PRIMARY KEY (alarm_id, receiver)
) STRICT, WITHOUT ROWID;

CREATE TABLE alarm_shelf (  -- conditions that somebody has set aside until an instant
  shelf_id INTEGER PRIMARY KEY,
  kind TEXT NOT NULL,
  subject TEXT NOT NULL,
  at_ns INTEGER NOT NULL,
  until_ns INTEGER NOT NULL,
  who TEXT NOT NULL,
  reason TEXT NOT NULL,
  ended_ns INTEGER NOT NULL,  -- 0: it stands
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
CREATE UNIQUE INDEX alarm_shelf_standing ON alarm_shelf (kind, subject) WHERE ended_ns = 0;
)sql";

}  // namespace driftwise::storage
