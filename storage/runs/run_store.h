#pragma once

#include "server/core/ports/store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteRunStore final : public RunStore {
 public:
  explicit SqliteRunStore(Session& session) : session_(session) {}

  Result<RunRecord> create_run(const NewRun& run) override;
  Result<void> change_run(RunId run, const RunChange& change) override;
  Result<RunRecord> run(RunId run) override;
  Result<std::vector<RunRecord>> runs(int limit, std::int64_t before_id) override;
  Result<std::optional<RunRecord>> unfinished_run() override;
  Result<RunRecord> import_dataset(const NewRun& run, const Dataset& dataset) override;
  Result<Dataset> dataset(std::span<const RunId> runs) override;

 private:
  Session& session_;
};

class SqlitePointStore final : public PointStore {
 public:
  explicit SqlitePointStore(Session& session) : session_(session) {}

  Result<DatumId> open_datum(const DatumRecord& datum) override;
  Result<std::optional<PointId>> commit(const PointCommit& commit) override;
  Result<std::vector<PointRecord>> points(RunId run, std::int64_t after_id, int limit) override;
  Result<std::vector<AttemptRecord>> attempts(RunId run) override;
  Result<std::vector<DatumRecord>> data(RunId run) override;
  Result<std::optional<DatumRecord>> newest_datum() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
