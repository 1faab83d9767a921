#pragma once
// What a person may ask of the record as a whole. Executor's thread.

#include <optional>

#include "server/core/ports/awaitable.h"
#include "server/core/records/audit_records.h"
#include "server/core/result.h"

namespace driftwise::application {

class RecordKeeping {
 public:
  virtual ~RecordKeeping() = default;
  // server/core/ports/audit_store.h; on the thread of the checks, one after the other.
  virtual Awaitable<Result<ChainReport>> verify(std::optional<ChainHead> kept) = 0;
};

}  // namespace driftwise::application
