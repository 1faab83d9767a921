#pragma once
// Version 1 of the database as SQL text: what a person with the sqlite3 shell sees under .schema.
// Never edited once released; a change is a new version with its own text
// (storage/schema/schema.cc).

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV1 =
    R"sql(
CREATE TABLE cell_config (  -- every cell.toml that a run was made with
  hash TEXT NOT NULL PRIMARY KEY,
  text TEXT NOT NULL
) STRICT, WITHOUT ROWID;

CREATE TABLE channel (  -- one named quantity with its unit: t07_degC
  channel_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  in_point INTEGER NOT NULL DEFAULT 0,   -- 1: has a column in the view point_wide
  in_reading INTEGER NOT NULL DEFAULT 0  -- 1: has a column in the view reading_wide
) STRICT;

CREATE TABLE device (
  device_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE  -- its id in cell.toml
) STRICT;

CREATE TABLE run (  -- one execution of a trajectory, or one imported file: what never changes
  run_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  trajectory_name TEXT NOT NULL,
  trajectory_text TEXT NOT NULL,  -- the file as it was given
  trajectory_rows INTEGER NOT NULL,
  rules_json TEXT NOT NULL,       -- the rules of [run] as used
  config_hash TEXT NOT NULL REFERENCES cell_config (hash),
  operator_name TEXT NOT NULL,
  request_id TEXT NOT NULL,       -- empty: none
  created_ns INTEGER NOT NULL,    -- UTC, nanoseconds since 1970, like every *_ns that is not *_monotonic_ns
  created_monotonic_ns INTEGER NOT NULL,  -- nanoseconds since the daemon started: never runs back
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(
) STRICT;
CREATE UNIQUE INDEX run_request ON run (request_id) WHERE request_id <> '';

CREATE TABLE run_progress (  -- where each run stands; its own table because every point rewrites it
  run_id INTEGER PRIMARY KEY REFERENCES run (run_id),
  state TEXT NOT NULL CHECK (state IN ('queued', 'running', 'paused', 'waiting', 'done', 'aborted', 'failed')),
  reason TEXT NOT NULL DEFAULT '',
  started_ns INTEGER NOT NULL DEFAULT 0,  -- 0: not yet
  ended_ns INTEGER NOT NULL DEFAULT 0,
  next_row INTEGER NOT NULL DEFAULT 0,    -- trajectory rows before it are decided, except those of requeued
  requeued TEXT NOT NULL DEFAULT '',      -- "row:count row:count": visited again at the end of their line
  accepted INTEGER NOT NULL DEFAULT 0,
  given_up INTEGER NOT NULL DEFAULT 0,
  attempts INTEGER NOT NULL DEFAULT 0,
  restarts INTEGER NOT NULL DEFAULT 0,
  max_lag_s REAL NOT NULL DEFAULT 0
) STRICT;

CREATE TABLE datum (  -- one stretch of data between two zeroings
  datum_id INTEGER PRIMARY KEY,
  run_id INTEGER REFERENCES run (run_id),
  opened_ns INTEGER NOT NULL,
  opened_monotonic_ns INTEGER NOT NULL,
  reason TEXT NOT NULL,
  file_datum INTEGER,  -- imported: its number in the file
  )sql" DRIFTWISE_UTC_COLUMN("opened") R"sql(
) STRICT;
CREATE INDEX datum_run ON datum (run_id);

-- Measured values are declared ANY and hold REAL or NULL (not measured): in a column declared REAL, SQLite
-- would store -0.0 as 0.
CREATE TABLE datum_value (  -- readings before the zeroing, and every temperature at that instant
  datum_id INTEGER NOT NULL REFERENCES datum (datum_id),
  channel_id INTEGER NOT NULL REFERENCES channel (channel_id),
  value ANY CHECK (typeof(value) IN ('real', 'null')),
  PRIMARY KEY (datum_id, channel_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE point (  -- one accepted visit of a trajectory row
  point_id INTEGER PRIMARY KEY,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  trajectory_row INTEGER NOT NULL,  -- counted from 0
  datum_id INTEGER NOT NULL REFERENCES datum (datum_id),
  point_set TEXT NOT NULL CHECK (point_set IN ('calibration', 'validation')),
  line INTEGER NOT NULL,
  is_zero INTEGER NOT NULL CHECK (is_zero IN (0, 1)),  -- 1: a return to zero
  measured_ns INTEGER NOT NULL,     -- middle of its readings
  measured_monotonic_ns INTEGER NOT NULL,
  dwell_s ANY,                      -- between the end of the move and the measurement
  file_time_s ANY,                  -- imported: time_s and run as they stand in the file
  file_run INTEGER,
  )sql" DRIFTWISE_UTC_COLUMN("measured") R"sql(
) STRICT;
CREATE UNIQUE INDEX point_place ON point (run_id, trajectory_row);  -- a row is accepted once

CREATE TABLE point_value (  -- joined values: means of the readings, temperatures at that time, commanded coordinates
  point_id INTEGER NOT NULL REFERENCES point (point_id),
  channel_id INTEGER NOT NULL,
  value ANY CHECK (typeof(value) IN ('real', 'null')),
  PRIMARY KEY (point_id, channel_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE imported_file (  -- runs that came from a dataset file: what the file had beside its values
  run_id INTEGER PRIMARY KEY REFERENCES run (run_id),
  fields TEXT NOT NULL  -- those of "time_s set line zero dwell_s run datum" that it had
) STRICT;
CREATE TABLE imported_metadata (  -- its leading "# key: value" lines
  run_id INTEGER NOT NULL REFERENCES imported_file (run_id),
  position INTEGER NOT NULL,
  key TEXT NOT NULL,
  value TEXT NOT NULL,
  PRIMARY KEY (run_id, position)
) STRICT, WITHOUT ROWID;
CREATE TABLE imported_column (  -- its channels, in the file's order
  run_id INTEGER NOT NULL REFERENCES imported_file (run_id),
  position INTEGER NOT NULL,
  channel_id INTEGER NOT NULL REFERENCES channel (channel_id),
  PRIMARY KEY (run_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE attempt (  -- one try at a point, kept whatever came of it
  attempt_id INTEGER PRIMARY KEY,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  trajectory_row INTEGER NOT NULL,
  number INTEGER NOT NULL,  -- counts the row's attempts within the run, from 1
  verdict TEXT NOT NULL
    CHECK (verdict IN ('accepted', 'reread', 'reapproach', 'requeued', 'given_up', 'interrupted')),
  reason TEXT NOT NULL,     -- empty when accepted
  started_ns INTEGER NOT NULL,
  started_monotonic_ns INTEGER NOT NULL,
  ended_ns INTEGER NOT NULL,
  ended_monotonic_ns INTEGER NOT NULL,
  spread_nm ANY,            -- standard deviation of its readings
  )sql" DRIFTWISE_UTC_COLUMN("started") R"sql(
) STRICT;
CREATE UNIQUE INDEX attempt_place ON attempt (run_id, trajectory_row, number);

CREATE TABLE reading (  -- one device's answer: never altered, never deleted
  reading_id INTEGER PRIMARY KEY,
  device_id INTEGER NOT NULL,
  start_ns INTEGER NOT NULL,  -- by the device's own clock where it has one
  end_ns INTEGER NOT NULL,
  sequence INTEGER NOT NULL,  -- counts the device's readings since its driver started
  attempt_id INTEGER,         -- the attempt it belongs to; NULL: the recorder's
  )sql" DRIFTWISE_UTC_COLUMN("start") R"sql(
) STRICT;
CREATE INDEX reading_time ON reading (device_id, start_ns);

CREATE TABLE reading_value (
  reading_id INTEGER NOT NULL,
  channel_id INTEGER NOT NULL,
  value ANY CHECK (typeof(value) IN ('real', 'null')),  -- NULL: the channel gave no value
  PRIMARY KEY (reading_id, channel_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE move (  -- one row per motor axis of each move
  at_ns INTEGER NOT NULL,
  ordinal INTEGER NOT NULL,  -- tells moves of the same instant apart
  axis INTEGER NOT NULL,     -- 1: q1. 0: a move that names no axis
  at_monotonic_ns INTEGER NOT NULL,
  run_id INTEGER,
  from_mm ANY,
  to_mm ANY,
  cause TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(,
  PRIMARY KEY (at_ns, ordinal, axis)
) STRICT, WITHOUT ROWID;

CREATE TABLE model (  -- immutable fit results
  model_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  json TEXT NOT NULL,         -- driftwise.model.v1: the model whole
  hash TEXT NOT NULL UNIQUE,  -- of the json
  parent_id INTEGER REFERENCES model (model_id),
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  note TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(
) STRICT;

CREATE TABLE promotion (  -- which model serves: the last row says it
  promotion_id INTEGER PRIMARY KEY,
  model_id INTEGER REFERENCES model (model_id),  -- NULL: none serves
  at_ns INTEGER NOT NULL,
  by_whom TEXT NOT NULL,
  action TEXT NOT NULL,       -- promote or rollback
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;

CREATE TABLE event (  -- everything that changed something, with who said it
  event_id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  who TEXT NOT NULL,
  peer TEXT NOT NULL,         -- network address; empty for the daemon
  what TEXT NOT NULL,         -- dotted and stable: run.started
  detail TEXT NOT NULL,
  run_id INTEGER,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;

CREATE VIEW run_overview AS
  SELECT run.run_id, run.name, state, reason, next_row, trajectory_rows, accepted, given_up, attempts, restarts,
         max_lag_s, created_utc, (ended_ns - started_ns) / 1e9 AS duration_s
  FROM run JOIN run_progress USING (run_id);
)sql";

}  // namespace driftwise::storage
