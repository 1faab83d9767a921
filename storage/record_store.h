#pragma once

#include "server/core/ports/watch_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteRecordStore final : public RecordStore {
 public:
  explicit SqliteRecordStore(Session& session) : session_(session) {}
  Result<std::string> database_id() override;
  Result<RecordCursor> newest() override;
  Result<RecordPage> records(const RecordCursor& after, const RecordCursor& until,
                             int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
