#pragma once
// Indentations as the store keeps them (server/indentation has the procedure).

#include <compare>
#include <cstdint>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise {

struct IndentationId {
  std::int64_t value = 0;
  auto operator<=>(const IndentationId&) const = default;
};

struct IndentationRecord {
  IndentationId id{};
  std::string key;          // of the client's record file: the same key is the same indentation
  std::string file_text;    // indentation.toml, as the last start had it
  std::string record_json;  // record of the procedure, as reported last: procedure_json.h
  std::string ended;  // reason of the end of the client that reported last; empty: none reported
  std::string microscope_csv;  // table of the microscope, as imported last; empty: none
  CellTime created, reported;  // first and last report
  std::string created_by, created_from;
};

}  // namespace driftwise
