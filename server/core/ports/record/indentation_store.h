#pragma once
// Indentations: a part of server/core/ports/store.h, with its thread and its errors.

#include <vector>

#include "server/core/records/indentation_record.h"
#include "server/core/result.h"

namespace driftwise {

class IndentationStore {
 public:
  virtual ~IndentationStore() = default;
  // Its id is ignored and given. A key that is stored already: the record that is there, unchanged.
  virtual Result<IndentationRecord> add_indentation(const IndentationRecord& record) = 0;
  // File, record, end, table and time of the last report become those given. Errors: not_found
  // NO_SUCH_RECORD.
  virtual Result<void> change_indentation(const IndentationRecord& record) = 0;
  virtual Result<IndentationRecord> indentation(IndentationId id) = 0;  // not_found NO_SUCH_RECORD
  virtual Result<std::vector<IndentationRecord>> indentations(int limit) = 0;  // newest first
};

}  // namespace driftwise
