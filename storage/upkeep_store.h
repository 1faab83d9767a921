#pragma once

#include <functional>

#include "server/core/ports/upkeep_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteUpkeepStore final : public UpkeepStore {
 public:
  // set_up: readies a connection that has just been opened; throws StorageFailure.
  SqliteUpkeepStore(Session& session, std::function<void()> set_up)
      : session_(session), set_up_(std::move(set_up)) {}
  DatabaseFiles files() override { return session_.files.look(); }
  Result<void> secure() override;
  Result<void> reopen() override;
  Result<void> copy_to(const std::string& path) override;
  Result<std::vector<std::string>> tables() override;
  Result<std::string> check(const std::string& table,
                            const std::function<bool()>& give_way) override;
  Result<DatabaseChecks> checks() override;
  Result<void> keep_check(const TableCheck& check, CellTime begun, bool all_clean) override;

 private:
  Session& session_;
  std::function<void()> set_up_;
};

}  // namespace driftwise::storage
