#pragma once

#include "server/core/ports/audit_store.h"
#include "storage/chain/protected_tables.h"
#include "storage/readings/kept_stretches.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteAuditStore final : public AuditStore {
 public:
  // tables: of the session's connection; those of a reading store are made when they are needed.
  SqliteAuditStore(Session& session, std::optional<ProtectedTables>& tables)
      : session_(session), tables_(tables) {}
  Result<AuditRecord> add(const AuditRecord& act, const std::optional<EventRecord>& event) override;
  Result<std::vector<AuditRecord>> acts(std::int64_t before_id, int limit) override;
  Result<ChainHead> head() override;
  Result<ChainReport> verify(const std::optional<ChainHead>& outside,
                             const std::function<bool()>& give_way) override;
  Result<RecordCopy> back_up(const std::string& path,
                             const std::function<bool()>& give_way) override;
  std::string record_in(const std::string& path) override;
  Result<ThinningStep> thin(const ThinningOrder& order) override;

 private:
  Session& session_;
  std::optional<ProtectedTables>& tables_;
  KeptStretches kept_;  // from step to step of a thinning
};

}  // namespace driftwise::storage
