#pragma once
// The queue of campaigns and the metadata of runs (storage/schema/schema_v9.h). Thread: the
// session's.

#include "server/core/ports/queue_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteQueueStore final : public QueueStore {
 public:
  explicit SqliteQueueStore(Session& session) : session_(session) {}

  Result<QueueRecord> queue(int history) override;
  Result<void> change_queue(const QueueChange& change) override;

 private:
  Session& session_;
};

class SqliteMetadataStore final : public MetadataStore {
 public:
  explicit SqliteMetadataStore(Session& session) : session_(session) {}

  Result<RunRecord> tag(RunId run, const RunMetadata& set,
                        const std::vector<std::string>& removed) override;
  Result<std::vector<RunRecord>> find_runs(const RunMetadata& all_of, int limit,
                                           std::int64_t before_id) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
