#pragma once

#include "server/core/ports/outside/outbox_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteOutboxStore final : public OutboxStore {
 public:
  explicit SqliteOutboxStore(Session& session) : session_(session) {}
  Result<OpenTellings> open(std::span<const std::string> receivers, CellTime now,
                            CellTime over_after) override;
  Result<void> put(std::span<const TellingRecord> tellings) override;
  Result<std::vector<TellingRecord>> tellings(int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
