#pragma once
// Which entry of the queue starts now, and why the others wait. Pure.
//
// Entries wait in the order of their priority, the higher first, and of their place. One that is
// not ready (its time, the entry before it, its condition) lets those behind it pass: the first one
// that is ready starts. Only one runs.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/alarm_condition.h"
#include "server/application/queue/queue_condition.h"
#include "server/core/records/queue_records.h"

namespace driftwise::application {

struct QueueSituation {
  const std::vector<QueueEntry>* entries = nullptr;
  QueueHold hold;
  UtcTime now;
  std::string busy;  // why nothing can start now, a clause: "run 5 'grid' is running"; empty: free
  std::map<QueueEntryId, ConditionVerdict> conditions;  // of entries that have one
};

struct QueueTurn {
  std::optional<QueueEntryId> starts;
  std::map<QueueEntryId, std::string> waits;  // a sentence per entry that waits and does not start
};

// Entries that wait, in their order.
std::vector<const QueueEntry*> waiting_in_order(const std::vector<QueueEntry>& entries);
const QueueEntry* find_entry(const std::vector<QueueEntry>& entries, QueueEntryId id);
// "entry 4 'night 2'".
std::string entry_text(const QueueEntry& entry);

// Leaves what the store gives at a start: what is not over, what that waits for, and the newest.
void forget_old_entries(std::vector<QueueEntry>& entries, int newest);

// Begin of a hold's reason where a person asked for it; others are of a stop or of a failure.
inline constexpr const char* kHeldByPerson = "held by ";

// Alarms of the queue by the stored state alone, so that a daemon that dies right after storing
// it tells it at its next start: entries that failed and wait in the held queue, entries that were
// set aside, and a queue that a stop or a failure holds while entries wait.
std::vector<AlarmCondition> queue_alarms(const QueueRecord& record);

QueueTurn decide_turn(const QueueSituation& situation);

// Errors: not_found NO_SUCH_QUEUE_ENTRY (after names none); failed_precondition QUEUE_CYCLE (the
// entry would wait for itself).
Result<void> check_dependency(const std::vector<QueueEntry>& entries, QueueEntryId id,
                              QueueEntryId after);

}  // namespace driftwise::application
