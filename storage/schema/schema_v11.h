#pragma once
// Version 11: serving plans. Never edited once released; a later change is a new version with its
// own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV11 =
    R"sql(
CREATE TABLE plan (  -- what a joint target is made of
  plan_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  version INTEGER NOT NULL,        -- of this name, from 1
  text TEXT NOT NULL,              -- plan.toml as it was given
  hash TEXT NOT NULL UNIQUE,       -- of the text
  request_id TEXT NOT NULL,        -- empty: none
  created_ns INTEGER NOT NULL,
  created_by TEXT NOT NULL,
  created_from TEXT NOT NULL,      -- network address
  note TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(,
  UNIQUE (name, version)
) STRICT;

CREATE TABLE plan_model (  -- models that a plan names, and what they were then
  plan_id INTEGER NOT NULL REFERENCES plan (plan_id),
  model_id INTEGER NOT NULL REFERENCES model (model_id),
  hash TEXT NOT NULL,              -- of the model
  PRIMARY KEY (plan_id, model_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE plan_promotion (  -- which plan serves since when; the last row counts
  plan_promotion_id INTEGER PRIMARY KEY,
  plan_id INTEGER REFERENCES plan (plan_id),  -- NULL: none
  at_ns INTEGER NOT NULL,
  by_whom TEXT NOT NULL,
  from_where TEXT NOT NULL,        -- network address
  action TEXT NOT NULL CHECK (action IN ('promote', 'rollback')),
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
)sql";

}  // namespace driftwise::storage
