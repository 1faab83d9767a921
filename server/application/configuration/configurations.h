#pragma once
// Cell files that were in force: compared, accepted. Executor's thread.

#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/configuration_records.h"
#include "server/core/result.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

struct ConfigurationView {
  std::string hash, text;
  std::string compared_hash;
  std::vector<formats::ConfigurationChange> changes;  // from this one to the one compared with
};

class Configurations {
 public:
  virtual ~Configurations() = default;
  // Empty hashes: the present one. Errors: not_found NO_SUCH_CONFIGURATION; failed_precondition
  // OLD_CONFIGURATION (compared with one that this program cannot read).
  virtual Awaitable<Result<ConfigurationView>> get(std::string hash, std::string compare_hash) = 0;
  // A person has seen the difference to this configuration. The unfinished run continues, targets
  // are served again. Errors: failed_precondition NO_QUESTION, OTHER_CONFIGURATION (hash is not the
  // present one).
  virtual Awaitable<Result<ConfigurationStart>> accept(Caller caller, std::string hash,
                                                       std::string note) = 0;
};

}  // namespace driftwise::application
