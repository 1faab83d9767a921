#pragma once
// What a person may ask of the record as a whole. Executor's thread.

#include <optional>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/copy_records.h"
#include "server/core/records/thinning_records.h"
#include "server/core/result.h"

namespace driftwise::application {

class RecordKeeping {
 public:
  virtual ~RecordKeeping() = default;
  // server/core/ports/audit_store.h; on the thread of the checks, one after the other.
  virtual Awaitable<Result<ChainReport>> verify(std::optional<ChainHead> kept) = 0;
  // A verified copy into the folder of backups; on the same thread. Errors: failed_precondition
  // BACKUP_UNDER_WAY; those of the disk.
  virtual Awaitable<Result<RecordCopy>> back_up(Caller caller) = 0;
  // Thins raw readings of the environment in small transactions, between those of the cell. order:
  // before, every_ns and reducer. Result: what was removed and stored, together. Errors:
  // invalid_argument BAD_REDUCER, BAD_RANGE (also: before is less than an hour ago);
  // failed_precondition THINNING_UNDER_WAY; those of the disk, with what was done staying done.
  virtual Awaitable<Result<ThinningStep>> thin(ThinningOrder order, Caller caller) = 0;
};

}  // namespace driftwise::application
