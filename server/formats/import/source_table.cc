#include "server/formats/import/source_table.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

std::string SourceTable::shown_name(std::size_t field) const {
  return has_header && field < names.size() ? "column " + shown(names[field])
                                            : "column " + std::to_string(field + 1);
}

Result<std::size_t> SourceTable::find(const SourceColumn& column, const std::string& place,
                                      const std::string& file_name) const {
  const auto problem = [&](Reason reason, const std::string& sentence) {
    return fail(ErrorCode::invalid_argument, reason,
                at_line(file_name, header_line) + place + " of the mapping: " + sentence);
  };
  if (column.name.empty()) {
    const auto index = static_cast<std::size_t>(column.number) - 1;
    if (column.number >= 1 && index < names.size()) return index;
    return problem(reasons::kUnknownColumn, "asked for column " + std::to_string(column.number) +
                                                ", found " + std::to_string(names.size()) +
                                                " columns");
  }
  if (!has_header)
    return problem(reasons::kUnknownColumn,
                   "asked for " + shown(column.name) +
                       ", but the file has no header row (header = false): give "
                       "the column's number");
  const auto count = std::ranges::count(names, column.name);
  if (count == 1)
    return static_cast<std::size_t>(std::ranges::find(names, column.name) - names.begin());
  if (count > 1)
    return problem(reasons::kAmbiguousColumn, "found " + std::to_string(count) + " columns named " +
                                                  shown(column.name) +
                                                  ": give the column's number");
  const std::string nearest =
      nearest_word(column.name, std::vector<std::string_view>(names.begin(), names.end()));
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + shown(name);
  if (names.size() == 1) list += " (one column: is the mapping's separator the file's?)";
  return problem(
      reasons::kUnknownColumn,
      "found no column named " + shown(column.name) +
          (nearest.empty() ? ", found " + list : ": did you mean " + shown(nearest) + "?"));
}

}  // namespace driftwise::formats
