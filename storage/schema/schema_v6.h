#pragma once
// Version 6: configurations in force, pending stops, suspect points, verification of the record.
// Never edited once released; a later change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV6 =
    R"sql(
-- Each subject below is independent of the others.

-- Gains of an improvement: mean and A90 with every U90, and the model before on the fresh points.
ALTER TABLE improvement_gain ADD COLUMN mean_before REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_predicted REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_predicted REAL;
ALTER TABLE improvement_gain ADD COLUMN u90_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_measured REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_measured REAL;

-- Clock.
CREATE TABLE clock (  -- a start of the daemon, or a step of the wall clock: how cell time was tied to UTC
  clock_id INTEGER PRIMARY KEY,
  from_ns INTEGER NOT NULL,    -- cell time; from here on UTC is cell time plus offset_ns
  offset_ns INTEGER NOT NULL,
  step_ns INTEGER NOT NULL,    -- of the wall clock; 0: a start without one
  boot TEXT NOT NULL,          -- the computer's start, boot_id
  boot_ns INTEGER NOT NULL,    -- CLOCK_BOOTTIME at from_ns
  ahead_ns INTEGER NOT NULL,   -- the wall clock minus boot_ns at from_ns
  from_utc TEXT GENERATED ALWAYS AS (strftime('%Y-%m-%dT%H:%M:%fZ', (from_ns + offset_ns) / 1e9, 'unixepoch'))
) STRICT;
CREATE INDEX clock_from ON clock (from_ns);

-- Stops.
CREATE TABLE stop (  -- a stop that a person asked for, one row per motion controller
  stop_id INTEGER PRIMARY KEY,
  controller TEXT NOT NULL,      -- its id in cell.toml
  who TEXT NOT NULL,
  from_peer TEXT NOT NULL,
  cause TEXT NOT NULL,           -- "stopped by ada"
  asked_ns INTEGER NOT NULL,
  asked_monotonic_ns INTEGER NOT NULL,
  presses INTEGER NOT NULL,      -- requests while it was pending
  confirmed_ns INTEGER NOT NULL  -- the controller had reported no motion twice in succession; 0: pending
) STRICT;
CREATE UNIQUE INDEX stop_pending ON stop (controller) WHERE confirmed_ns = 0;
-- What a run stands for, and on which start of the computer it was under way.
ALTER TABLE run_progress ADD COLUMN hold_kind TEXT NOT NULL DEFAULT ''
  CHECK (hold_kind IN ('', 'pause', 'stop', 'trouble', 'restart', 'configuration'));
ALTER TABLE run_progress ADD COLUMN hold_who TEXT NOT NULL DEFAULT '';
ALTER TABLE run_progress ADD COLUMN hold_ns INTEGER NOT NULL DEFAULT 0;
ALTER TABLE run_progress ADD COLUMN boot_id TEXT NOT NULL DEFAULT '';

-- Check of the database's own pages.
CREATE TABLE database_check (  -- one row: the last check of a table
  table_name TEXT PRIMARY KEY,
  checked_ns INTEGER NOT NULL,
  trouble TEXT NOT NULL,  -- empty: clean
  )sql" DRIFTWISE_UTC_COLUMN("checked") R"sql(
) STRICT;
CREATE TABLE database_check_pass (  -- one row: how far the checks are
  pass INTEGER PRIMARY KEY CHECK (pass = 1),
  begun_ns INTEGER NOT NULL,      -- tables checked since then belong to the present pass
  last_clean_ns INTEGER NOT NULL, -- when a pass last ended with every table clean; 0: never
  )sql" DRIFTWISE_UTC_COLUMN("last_clean") R"sql(
) STRICT;

-- Configurations in force.
CREATE TABLE configuration_start (  -- one start of the daemon, with the cell.toml that it read
  start_id INTEGER PRIMARY KEY,
  config_hash TEXT NOT NULL REFERENCES cell_config (hash),
  before_hash TEXT NOT NULL,     -- the one it was compared with; empty: the first start
  changes_json TEXT NOT NULL,    -- the difference, by meaning
  asks INTEGER NOT NULL CHECK (asks IN (0, 1)),  -- 1: a person has to answer
  version TEXT NOT NULL,         -- of the program
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  accepted_ns INTEGER NOT NULL,  -- 0: not yet
  accepted_by TEXT NOT NULL,
  note TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
CREATE TABLE run_configuration (  -- a run went on under this cell.toml; it began under run.config_hash
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  position INTEGER NOT NULL,
  config_hash TEXT NOT NULL REFERENCES cell_config (hash),
  from_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("from") R"sql(,
  PRIMARY KEY (run_id, position)
) STRICT, WITHOUT ROWID;

-- Corrections that data rest on.
CREATE TABLE model_correction (  -- in force when the model was fitted, over its runs
  model_id INTEGER NOT NULL REFERENCES model (model_id),
  correction_id INTEGER NOT NULL REFERENCES correction (correction_id),
  PRIMARY KEY (model_id, correction_id)
) STRICT, WITHOUT ROWID;
CREATE TABLE correction_change (  -- what a correction did to the runs there were when it was accepted
  correction_id INTEGER NOT NULL REFERENCES correction (correction_id),
  position INTEGER NOT NULL,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  channel TEXT NOT NULL,
  from_ns INTEGER NOT NULL,      -- first row that changes; 0: an imported run
  row_count INTEGER NOT NULL,    -- rows that change by 0.1 nm or more
  largest_nm REAL NOT NULL,
  rms_nm REAL NOT NULL,
  diagnosed INTEGER NOT NULL CHECK (diagnosed IN (0, 1)),  -- 1: the diagnosis looked at this run
  PRIMARY KEY (correction_id, position)
) STRICT, WITHOUT ROWID;
-- False data: what the tests of plausibility found (docs/database.md).
CREATE TABLE rejected_value (  -- a value that joins no point: its reading keeps it as the device gave it
  device_id INTEGER NOT NULL,
  start_ns INTEGER NOT NULL,  -- of the reading, with its sequence: which one it is
  sequence INTEGER NOT NULL,
  channel_id INTEGER NOT NULL,
  test TEXT NOT NULL,         -- missing, not_finite, range, step, together, frozen
  reason TEXT NOT NULL,       -- the value, the limit, where the limit comes from
  PRIMARY KEY (device_id, start_ns, sequence, channel_id)
) STRICT, WITHOUT ROWID;

CREATE VIEW rejected_reading AS  -- with the value as it was given
  SELECT d.name AS device, r.start_utc, r.start_ns, r.sequence, c.name AS channel, v.value, x.test, x.reason,
         r.reading_id, r.attempt_id
  FROM rejected_value x
  JOIN device d USING (device_id)
  JOIN channel c USING (channel_id)
  JOIN reading r ON r.device_id = x.device_id AND r.start_ns = x.start_ns AND r.sequence = x.sequence
  LEFT JOIN reading_value v ON v.reading_id = r.reading_id AND v.channel_id = x.channel_id;

CREATE TABLE suspect_mark (  -- exclusions that the daemon made: their rows rest on a false instrument or zero
  exclusion_id INTEGER PRIMARY KEY REFERENCES exclusion (exclusion_id)
) STRICT;

CREATE VIEW suspect_point AS  -- the rows that are suspect now: marked, and put back by nobody
  SELECT run_id, trajectory_row, exclusion_id, reason, at_utc
  FROM excluded_point JOIN suspect_mark USING (exclusion_id);
)sql";

}  // namespace driftwise::storage
