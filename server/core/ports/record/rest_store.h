#pragma once
// A cell left at rest: a part of server/core/ports/store.h, with its thread and its errors.

#include <optional>
#include <string>

#include "server/core/records/rest_record.h"
#include "server/core/result.h"

namespace driftwise {

class RestStore {
 public:
  virtual ~RestStore() = default;
  // One that is under way is over with it. Answers with the record's id.
  virtual Result<std::int64_t> begin_rest(const RestRecord& rest) = 0;
  virtual Result<void> end_rest(std::int64_t id, CellTime at, const std::string& reason) = 0;
  virtual Result<std::optional<RestRecord>> newest_rest() = 0;
};

}  // namespace driftwise
