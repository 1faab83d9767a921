#pragma once
// Version 12: remarks pinned to an instant. Never edited once released; a later change is a new
// version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV12 =
    R"sql(
CREATE TABLE time_note (  -- a remark on an instant; kept for ever
  time_note_id INTEGER PRIMARY KEY,
  about_ns INTEGER NOT NULL,  -- the instant
  text TEXT NOT NULL,
  channel TEXT NOT NULL,      -- empty: the cell
  request TEXT NOT NULL,      -- of whoever asked; empty: none
  who TEXT NOT NULL,
  peer TEXT NOT NULL,
  at_ns INTEGER NOT NULL,     -- when it was written
  at_monotonic_ns INTEGER NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;
CREATE INDEX time_note_about ON time_note (about_ns);
CREATE UNIQUE INDEX time_note_request ON time_note (request) WHERE request <> '';
)sql";

}  // namespace driftwise::storage
