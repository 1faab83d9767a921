#pragma once
// Version 13: returns to zero as they were judged, lines that were measured again, the cell at
// rest. Never edited once released; a later change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV13 =
    R"sql(
CREATE TABLE closure (  -- a return to zero as it was judged
  closure_id INTEGER PRIMARY KEY,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  datum_id INTEGER NOT NULL REFERENCES datum (datum_id),
  line INTEGER NOT NULL,
  repetition INTEGER NOT NULL,  -- of the line: 0 is the first time
  measured_ns INTEGER NOT NULL,
  measured_monotonic_ns INTEGER NOT NULL,
  side TEXT NOT NULL,           -- from which each axis came: q1+ q2-; empty: not known
  expected_by TEXT NOT NULL,    -- what the expectation rests on; empty: nothing
  decision TEXT NOT NULL CHECK (decision IN ('within', 'explained', 'play', 'marked', 'repeated', 'new_datum')),
  sentence TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("measured") R"sql(
) STRICT;
CREATE INDEX closure_run ON closure (run_id);

CREATE TABLE closure_coordinate (  -- its budget: nm of a length, arcsec of a rotation
  closure_id INTEGER NOT NULL REFERENCES closure (closure_id),
  channel_id INTEGER NOT NULL REFERENCES channel (channel_id),
  found ANY,        -- since the last good return from the same side
  allowed ANY,      -- limit of its size
  expected ANY,     -- by the temperatures
  expected_sd ANY,  -- standard deviation of that
  noise ANY,        -- declared standard uncertainty of the instrument
  play ANY,         -- of this side against the last return
  PRIMARY KEY (closure_id, channel_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE repeated_point (  -- its line was measured again: in no dataset
  point_id INTEGER PRIMARY KEY REFERENCES point (point_id),
  closure_id INTEGER NOT NULL REFERENCES closure (closure_id)  -- that was not explained
) STRICT;

-- A row has one point that counts. An index cannot see which points were repeated.
DROP INDEX point_place;
CREATE INDEX point_place ON point (run_id, trajectory_row);
CREATE TRIGGER point_once BEFORE INSERT ON point WHEN EXISTS (
  SELECT 1 FROM point WHERE run_id = new.run_id AND trajectory_row = new.trajectory_row
  AND point_id NOT IN (SELECT point_id FROM repeated_point))
BEGIN
  SELECT RAISE(ABORT, 'a row is accepted once');
END;

CREATE TABLE rest (  -- the cell left alone, to see when it is warm
  rest_id INTEGER PRIMARY KEY,
  begun_ns INTEGER NOT NULL,
  ended_ns INTEGER NOT NULL,    -- 0: under way
  begun_by TEXT NOT NULL,
  end_reason TEXT NOT NULL,     -- empty: under way
  length_nm_per_h REAL NOT NULL,  -- limits of drift, over windows of window_s
  temperature_k_per_h REAL NOT NULL,
  window_s REAL NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("begun") R"sql(
) STRICT;
)sql";

}  // namespace driftwise::storage
