#pragma once
// Which field of a row each rule of a mapping reads.

#include <optional>
#include <string>
#include <vector>

#include "server/formats/import/import_mapping.h"

namespace driftwise::formats {

// The file's columns: their names, or "column 3" where there is no header.
struct SourceTable {
  std::vector<std::string> names;
  std::size_t header_line = 0;
  bool has_header = false;

  std::string shown_name(std::size_t field) const;  // "column 'Goal x'"
  // Where a column stands, from 0. place: of the rule, "column 2". Errors: UNKNOWN_COLUMN,
  // AMBIGUOUS_COLUMN (two columns of one name: give the number).
  Result<std::size_t> find(const SourceColumn& column, const std::string& place,
                           const std::string& file_name) const;
};

}  // namespace driftwise::formats
