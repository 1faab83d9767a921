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

  // Newest first. Without history: those that still hold or nobody has acknowledged. Beyond the
  // limit the oldest are left out; without history those that are over before those that hold.
  virtual Awaitable<Result<std::vector<AlarmRecord>>> list(bool with_history, int limit) = 0;
  // Errors: not_found NO_SUCH_ALARM.
  virtual Awaitable<Result<AlarmRecord>> acknowledge(Caller caller, AlarmId id) = 0;
  // Sets the alarm's condition aside for a time: nobody is told of it, and it comes back by itself.
  // Errors: invalid_argument BAD_SHELF (no reason; not above 0 or beyond AlarmShelf::kLongest_s);
  // not_found NO_SUCH_ALARM.
  virtual Awaitable<Result<AlarmRecord>> shelve(Caller caller, AlarmId id, double for_s,
                                                std::string reason) = 0;
  virtual Awaitable<Result<AlarmRecord>> unshelve(Caller caller, AlarmId id) = 0;
  // Those that are otherwise than on record, or not on it (id 0), while it takes nothing: the
  // newest, at most as many.
  virtual std::vector<AlarmRecord> unwritten(std::size_t most) const = 0;
};

}  // namespace driftwise::application
