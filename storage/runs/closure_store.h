#pragma once
// Returns to zero and lines that were measured again (storage/schema/schema_v13.h). Thread: the
// session's.

#include "server/core/ports/record/closure_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteClosureStore final : public ClosureStore {
 public:
  explicit SqliteClosureStore(Session& session) : session_(session) {}

  Result<std::int64_t> add_closure(const ClosureRecord& closure,
                                   const std::optional<RepeatedLine>& repeated) override;
  Result<std::vector<ClosureRecord>> closures(RunId run) override;
  Result<std::vector<PointId>> repeated_points(RunId run) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
