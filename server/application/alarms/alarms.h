#pragma once
// Alarms: listed, acknowledged. Executor's thread.

#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/watch_records.h"
#include "server/core/result.h"

namespace driftwise::application {

class Alarms {
 public:
  virtual ~Alarms() = default;

  // Newest first. Without history: those that still hold or nobody has acknowledged.
  virtual Awaitable<Result<std::vector<AlarmRecord>>> list(bool with_history, int limit) = 0;
  // Errors: not_found NO_SUCH_ALARM.
  virtual Awaitable<Result<AlarmRecord>> acknowledge(Caller caller, AlarmId id) = 0;
};

}  // namespace driftwise::application
