#pragma once
// Version 2: what people say about the record. Rows kept out of fits and put back, and notes: both
// only ever grow. Never edited once released; a change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV2 =
    R"sql(
CREATE TABLE exclusion (  -- somebody kept rows of a run out of fits, or put them back
  exclusion_id INTEGER PRIMARY KEY,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  excluded INTEGER NOT NULL CHECK (excluded IN (0, 1)),  -- 0: put back
  reason TEXT NOT NULL,
  who TEXT NOT NULL,
  peer TEXT NOT NULL,         -- network address; empty for the daemon
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
CREATE INDEX exclusion_run ON exclusion (run_id);

CREATE TABLE exclusion_row (  -- which rows that changed
  exclusion_id INTEGER NOT NULL REFERENCES exclusion (exclusion_id),
  trajectory_row INTEGER NOT NULL,
  PRIMARY KEY (exclusion_id, trajectory_row)
) STRICT, WITHOUT ROWID;

CREATE VIEW excluded_point AS  -- the rows that are out now, by the last word on each
  SELECT e.run_id, r.trajectory_row, e.exclusion_id, e.reason, e.who, e.at_utc
  FROM exclusion e JOIN exclusion_row r USING (exclusion_id)
  WHERE e.excluded = 1 AND NOT EXISTS (
    SELECT 1 FROM exclusion later JOIN exclusion_row again USING (exclusion_id)
    WHERE later.run_id = e.run_id AND again.trajectory_row = r.trajectory_row
      AND later.exclusion_id > e.exclusion_id);

CREATE TABLE note (  -- a remark on a run, one of its points, or a model
  note_id INTEGER PRIMARY KEY,
  run_id INTEGER REFERENCES run (run_id),
  trajectory_row INTEGER,     -- with a run: on the point of this row
  model_id INTEGER REFERENCES model (model_id),
  text TEXT NOT NULL,
  who TEXT NOT NULL,
  peer TEXT NOT NULL,
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(,
  CHECK ((run_id IS NULL) <> (model_id IS NULL)),
  CHECK (trajectory_row IS NULL OR run_id IS NOT NULL)
) STRICT;
CREATE INDEX note_run ON note (run_id);
CREATE INDEX note_model ON note (model_id);
)sql";

}  // namespace driftwise::storage
