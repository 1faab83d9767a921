#pragma once
// Indentations (storage/schema/schema_v14.h). Thread: the session's.

#include "server/core/ports/record/indentation_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteIndentationStore final : public IndentationStore {
 public:
  explicit SqliteIndentationStore(Session& session) : session_(session) {}
  Result<IndentationRecord> add_indentation(const IndentationRecord& record) override;
  Result<void> change_indentation(const IndentationRecord& record) override;
  Result<IndentationRecord> indentation(IndentationId id) override;
  Result<std::vector<IndentationRecord>> indentations(int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
