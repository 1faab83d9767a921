#pragma once
// Version 3: diagnoses, what was made of them, and the loops that improve. Never edited once
// released; a change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV3 =
    R"sql(
CREATE TABLE diagnosis (  -- what the simulation gets wrong, as found in runs or in a file
  diagnosis_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('running', 'done', 'cancelled', 'failed')),
  reason TEXT NOT NULL,       -- why it failed or was cancelled
  model_id INTEGER REFERENCES model (model_id),  -- the simulation it began from
  baseline TEXT NOT NULL,     -- the formula of that simulation
  extended TEXT NOT NULL,     -- ... with what was found
  request_json TEXT NOT NULL,
  result_json TEXT NOT NULL,  -- empty until it is done
  rows_cbor BLOB,             -- discrepancy per row, for plots
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  ended_ns INTEGER NOT NULL,  -- 0: not yet
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(,
  )sql" DRIFTWISE_UTC_COLUMN("ended") R"sql(
) STRICT;

CREATE TABLE diagnosis_run (  -- the runs it looked at; none: a file
  diagnosis_id INTEGER NOT NULL REFERENCES diagnosis (diagnosis_id),
  position INTEGER NOT NULL,
  run_id INTEGER NOT NULL REFERENCES run (run_id),
  PRIMARY KEY (diagnosis_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE correction (  -- what fits see and the stored points do not; points are never altered
  correction_id INTEGER PRIMARY KEY,
  diagnosis_id INTEGER REFERENCES diagnosis (diagnosis_id),
  json TEXT NOT NULL,         -- driftwise.correction.v1
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  ended_ns INTEGER NOT NULL,  -- 0: in force
  ended_by TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(,
  )sql" DRIFTWISE_UTC_COLUMN("ended") R"sql(
) STRICT;

CREATE TABLE extension (  -- what was made of a diagnosis' findings
  extension_id INTEGER PRIMARY KEY,
  diagnosis_id INTEGER NOT NULL REFERENCES diagnosis (diagnosis_id),
  findings TEXT NOT NULL,     -- their numbers: "1 3"
  model_id INTEGER REFERENCES model (model_id),
  promoted INTEGER NOT NULL CHECK (promoted IN (0, 1)),
  correction_id INTEGER REFERENCES correction (correction_id),
  accepted_ns INTEGER NOT NULL,
  accepted_by TEXT NOT NULL,
  undone_ns INTEGER NOT NULL,  -- 0: it stands
  undone_by TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("accepted") R"sql(,
  )sql" DRIFTWISE_UTC_COLUMN("undone") R"sql(
) STRICT;
CREATE INDEX extension_diagnosis ON extension (diagnosis_id);
CREATE UNIQUE INDEX extension_standing ON extension (diagnosis_id) WHERE undone_ns = 0;

CREATE TABLE extension_exclusion (  -- the rows that it keeps out
  extension_id INTEGER NOT NULL REFERENCES extension (extension_id),
  exclusion_id INTEGER NOT NULL REFERENCES exclusion (exclusion_id),
  PRIMARY KEY (extension_id, exclusion_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE improvement (  -- a loop of measuring, fitting, diagnosing and extending
  improvement_id INTEGER PRIMARY KEY,
  state TEXT NOT NULL CHECK (state IN ('running', 'done', 'cancelled', 'failed')),
  reason TEXT NOT NULL,       -- why it ended
  trajectory_name TEXT NOT NULL,
  trajectory_text TEXT NOT NULL,
  formula TEXT NOT NULL,
  max_turns INTEGER NOT NULL,
  budget_s REAL NOT NULL,     -- 0: no limit
  promotes INTEGER NOT NULL CHECK (promotes IN (0, 1)),
  request_id TEXT NOT NULL,
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  ended_ns INTEGER NOT NULL,  -- 0: not yet
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(,
  )sql" DRIFTWISE_UTC_COLUMN("ended") R"sql(
) STRICT;
CREATE UNIQUE INDEX improvement_request ON improvement (request_id) WHERE request_id <> '';

CREATE TABLE improvement_turn (
  improvement_id INTEGER NOT NULL REFERENCES improvement (improvement_id),
  number INTEGER NOT NULL,
  runs TEXT NOT NULL,         -- their numbers: "3 4"
  model_id INTEGER REFERENCES model (model_id),
  diagnosis_id INTEGER REFERENCES diagnosis (diagnosis_id),
  what TEXT NOT NULL,
  started_ns INTEGER NOT NULL,
  ended_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("started") R"sql(,
  )sql" DRIFTWISE_UTC_COLUMN("ended") R"sql(,
  PRIMARY KEY (improvement_id, number)
) STRICT, WITHOUT ROWID;

CREATE TABLE improvement_gain (  -- per output: what was, was promised, and was measured on fresh points
  improvement_id INTEGER NOT NULL,
  number INTEGER NOT NULL,
  position INTEGER NOT NULL,
  output TEXT NOT NULL,
  unit TEXT NOT NULL,
  u90_before REAL NOT NULL,
  u90_predicted REAL,
  u90_measured REAL,
  PRIMARY KEY (improvement_id, number, position),
  FOREIGN KEY (improvement_id, number) REFERENCES improvement_turn (improvement_id, number)
) STRICT, WITHOUT ROWID;
)sql";

}  // namespace driftwise::storage
