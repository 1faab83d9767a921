#pragma once
// A cell left at rest (storage/schema/schema_v13.h). Thread: the session's.

#include "server/core/ports/record/rest_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteRestStore final : public RestStore {
 public:
  explicit SqliteRestStore(Session& session) : session_(session) {}
  Result<std::int64_t> begin_rest(const RestRecord& rest) override;
  Result<void> end_rest(std::int64_t id, CellTime at, const std::string& reason) override;
  Result<std::optional<RestRecord>> newest_rest() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
