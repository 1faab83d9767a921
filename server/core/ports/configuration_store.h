#pragma once
// Cell files that were in force: part of server/core/ports/store.h, with its threads and errors.

#include <optional>
#include <string>
#include <vector>

#include "server/core/records/configuration_records.h"
#include "server/core/result.h"

namespace driftwise {

class ConfigurationStore {
 public:
  virtual ~ConfigurationStore() = default;
  // Keeps the text under the start's hash, and the start. Answers with it as stored.
  virtual Result<ConfigurationStart> begin(const ConfigurationStart& start,
                                           const std::string& text) = 0;
  // The last configuration that puts no question: of a start that asks for nobody or was accepted;
  // on a database that knows no start, of the newest run. None: a new database.
  virtual Result<std::optional<std::string>> accepted_hash() = 0;
  virtual Result<std::vector<ConfigurationStart>> starts(int limit) = 0;  // newest first
  // Errors: not_found NO_SUCH_CONFIGURATION.
  virtual Result<std::string> text(const std::string& hash) = 0;
  // In one transaction: the answer, and that this run goes on under the start's configuration.
  // Errors: failed_precondition NO_QUESTION (it asks for nobody, or was accepted).
  virtual Result<ConfigurationStart> accept(std::int64_t start, CellTime at, const std::string& who,
                                            const std::string& note,
                                            std::optional<RunId> continued) = 0;
  // From here on the run is measured under this configuration.
  virtual Result<void> continue_run(RunId run, const UsedConfiguration& used) = 0;
  // Oldest first: the one it was created under, then those of continue_run that differ from the one
  // before; empty: its rows are a file's. Errors: not_found NO_SUCH_RUN.
  virtual Result<std::vector<UsedConfiguration>> of_run(RunId run) = 0;
};

}  // namespace driftwise
