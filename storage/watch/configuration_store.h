#pragma once
// Cell files that were in force (storage/schema/schema_v6.h). Thread: the session's.

#include "server/core/ports/configuration_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteConfigurationStore final : public ConfigurationStore {
 public:
  explicit SqliteConfigurationStore(Session& session) : session_(session) {}
  Result<ConfigurationStart> begin(const ConfigurationStart& start,
                                   const std::string& text) override;
  Result<std::optional<std::string>> accepted_hash() override;
  Result<std::vector<ConfigurationStart>> starts(int limit) override;
  Result<std::string> text(const std::string& hash) override;
  Result<ConfigurationStart> accept(std::int64_t start, CellTime at, const std::string& who,
                                    const std::string& note,
                                    std::optional<RunId> continued) override;
  Result<void> continue_run(RunId run, const UsedConfiguration& used) override;
  Result<std::vector<UsedConfiguration>> of_run(RunId run) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
