#pragma once
// Version 7: acts of people, and the chain over the record (docs/database.md, "The chain"). Never
// edited once released; a later change is a new version with its own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV7 =
    R"sql(
CREATE TABLE audit (  -- what somebody did, or was refused
  audit_id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  at_monotonic_ns INTEGER NOT NULL,
  who TEXT NOT NULL,
  proof TEXT NOT NULL,         -- of who: stated, peer credentials, certificate, token
  peer TEXT NOT NULL,          -- network address; empty: the daemon itself
  what TEXT NOT NULL,          -- dotted and stable: model.promoted
  subject TEXT NOT NULL,       -- model 3; empty: the cell
  before_value TEXT NOT NULL,  -- what it changed; empty: none
  after_value TEXT NOT NULL,
  outcome TEXT NOT NULL,       -- empty: done; else why it was refused
  event_id INTEGER REFERENCES event (event_id),  -- that tells of the same act
  )sql" DRIFTWISE_UTC_COLUMN("at") R"sql(
) STRICT;

CREATE TABLE chain (  -- entries without a gap, one or more per transaction that changed protected rows
  entry_id INTEGER PRIMARY KEY,  -- 1, 2, 3, ...
  what TEXT NOT NULL,            -- layout: columns of a kind of rows; begin: rows that were there; rows: as they were stored
  bytes BLOB NOT NULL,           -- a digest per row with the rows that belong to it, and a mark per row
  head BLOB NOT NULL             -- SHA-256 of the head before it, entry_id, what and bytes
) STRICT;
CREATE INDEX chain_layout ON chain (entry_id) WHERE what = 'layout';
)sql";

}  // namespace driftwise::storage
