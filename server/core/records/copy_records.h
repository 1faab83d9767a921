#pragma once
// A copy of the record, made while the cell works or put back without it.

#include <cstdint>
#include <string>

#include "server/core/records/audit_records.h"

namespace driftwise {

struct RecordCopy {
  std::string path;
  std::int64_t bytes = 0;
  std::int64_t rows = 0;  // of all tables, counted in the record and in the copy
  ChainHead head;         // of the copy's chain; entry 0: the record has none
};

}  // namespace driftwise
