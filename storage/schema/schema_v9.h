#pragma once
// Version 9: the queue of campaigns, and metadata of runs. Never edited once released; a later
// change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV9 =
    R"sql(
CREATE TABLE run_metadata (  -- what people say of a run by keys: sample, tool, purpose
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  key TEXT NOT NULL,
  value TEXT NOT NULL,
  PRIMARY KEY (run_id, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX run_metadata_value ON run_metadata (key, value);

CREATE TABLE queue_entry (  -- a campaign that waits, runs or is over
  entry_id INTEGER PRIMARY KEY,
  place INTEGER NOT NULL,          -- among entries of one priority, ascending
  state TEXT NOT NULL CHECK (state IN ('waiting', 'running', 'following', 'done', 'set aside', 'removed')),
  reason TEXT NOT NULL,            -- why it was set aside, put back or removed; empty: none
  name TEXT NOT NULL,
  trajectory_name TEXT NOT NULL,
  trajectory_text TEXT NOT NULL,
  trajectory_rows INTEGER NOT NULL,
  rules_json TEXT NOT NULL,        -- empty: the cell's when it starts
  compensate INTEGER NOT NULL CHECK (compensate IN (0, 1)),
  compensate_model_id INTEGER REFERENCES model (model_id),
  metadata TEXT NOT NULL,          -- key=value, a line each: of the run that it becomes
  priority INTEGER NOT NULL,       -- higher first
  not_before_ns INTEGER NOT NULL,  -- UTC; 0: none
  after_entry_id INTEGER REFERENCES queue_entry (entry_id),  -- has to be accepted first
  condition TEXT NOT NULL,         -- t12_degC < 20.5 degC for 30 min; empty: none
  on_failure TEXT NOT NULL CHECK (on_failure IN ('hold', 'set-aside')),
  repeat_every_s REAL NOT NULL,    -- from start to start; 0: once
  follow_ups TEXT NOT NULL,        -- a line each: fit:q ~ x
  request_id TEXT NOT NULL,
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  created_from TEXT NOT NULL,      -- network address
  run_id INTEGER REFERENCES run (run_id),  -- the last one
  begun_ns INTEGER NOT NULL,       -- that run was created; 0: not yet
  ended_ns INTEGER NOT NULL,       -- it was over; 0: not yet
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(
) STRICT;
CREATE INDEX queue_entry_open ON queue_entry (entry_id) WHERE state NOT IN ('done', 'removed');

CREATE TABLE queue_result (  -- what followed a run that was done
  entry_id INTEGER NOT NULL REFERENCES queue_entry (entry_id),
  position INTEGER NOT NULL,       -- of its line in follow_ups, from 0
  good INTEGER NOT NULL CHECK (good IN (0, 1)),
  text TEXT NOT NULL,              -- what was made, or why it failed
  model_id INTEGER REFERENCES model (model_id),
  diagnosis_id INTEGER REFERENCES diagnosis (diagnosis_id),
  at_ns INTEGER NOT NULL,
  PRIMARY KEY (entry_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE queue_run (  -- the entry that began a run
  run_id INTEGER PRIMARY KEY REFERENCES run (run_id),
  entry_id INTEGER NOT NULL REFERENCES queue_entry (entry_id)
) STRICT;
CREATE INDEX queue_run_entry ON queue_run (entry_id);

CREATE TABLE queue_hold (  -- at most one row: whether entries may start; none: they may
  one INTEGER PRIMARY KEY CHECK (one = 1),
  held INTEGER NOT NULL CHECK (held IN (0, 1)),
  who TEXT NOT NULL,               -- empty: the daemon
  why TEXT NOT NULL,
  at_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
)sql";

}  // namespace driftwise::storage
