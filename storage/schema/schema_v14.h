#pragma once
// Version 14: indentations. Never edited once released; a later change is a new version with its
// own text.

#include <string_view>

#include "storage/sqlite/utc_column.h"

namespace driftwise::storage {

constexpr std::string_view kSchemaV14 =
    R"sql(
CREATE TABLE indentation (  -- two robots that touch: a procedure that a client executes and reports
  indentation_id INTEGER PRIMARY KEY,
  key TEXT NOT NULL UNIQUE,      -- of the client's record file
  file_text TEXT NOT NULL,       -- indentation.toml, as the last start had it
  record_json TEXT NOT NULL,     -- record of the procedure, as reported last
  ended TEXT NOT NULL,           -- reason of the end of the client that reported last; empty: none reported
  microscope_csv TEXT NOT NULL,  -- table of the microscope, as imported last; empty: none
  created_ns INTEGER NOT NULL,
  reported_ns INTEGER NOT NULL,  -- last report
  created_by TEXT NOT NULL,
  created_from TEXT NOT NULL,
  )sql" DRIFTWISE_UTC_COLUMN("created") R"sql(
) STRICT;
)sql";

}  // namespace driftwise::storage
