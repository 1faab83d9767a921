#pragma once
// Version 6: configurations in force, pending stops, suspect points, verification of the record.
// Never edited once released; a later change is a new version with its own text.

#include <string_view>

#include "storage/utc_column.h"

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
  CHECK (hold_kind IN ('', 'pause', 'stop', 'trouble', 'restart'));
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
)sql";

}  // namespace driftwise::storage
