#pragma once
// Version 15: rows that a run passed beside its plan. Never edited once released; a later change is
// a new version with its own text.

#include <string_view>

namespace driftwise::storage {

constexpr std::string_view kSchemaV15 =
    R"sql(
CREATE TABLE passage (  -- points beside the plan: in the path of a dataset, in no fit
  point_id INTEGER PRIMARY KEY REFERENCES point (point_id)
) STRICT;

CREATE VIEW planned_point AS  -- points of the plan's rows: one for each accepted attempt
  SELECT * FROM point WHERE point_id NOT IN (SELECT point_id FROM passage);
)sql";

}  // namespace driftwise::storage
