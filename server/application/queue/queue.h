#pragma once
// Queue: campaigns that wait for their turn, added, changed and ordered while one runs. Executor's
// thread.
//
// The queue moves the robot in the name of whoever added the entry. It takes the lease to move for
// the moment of the start alone: a lease that anybody else holds keeps it waiting. A run that
// begins without a person having asked for it just now is announced for a minute before its first
// motion. A stop and an abort by a person hold the queue; a restart of the daemon does not.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/application/queue/queue_outlook.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/queue_records.h"
#include "server/core/result.h"

namespace driftwise::application {

// An entry as a person asks for it.
struct QueueDraft {
  std::string name, trajectory_name, trajectory_text, request_id;
  std::optional<RunRules> rules;  // none: the cell's when it starts
  bool compensate = false;
  std::optional<ModelId> compensate_with;
  std::string setup = {};  // [[setup]] of the cell file; empty: all instruments
  RunMetadata metadata;
  int priority = 0;
  UtcTime not_before;
  std::optional<QueueEntryId> after;
  std::string condition;  // queue_condition.h
  OnFailure on_failure = OnFailure::hold;
  double repeat_every_s = 0;
  std::vector<std::string> follow_ups;  // follow_up.h
};

// What is set is changed.
struct QueueEdit {
  std::optional<std::string> name;
  std::optional<int> priority;
  std::optional<UtcTime> not_before;  // 0: none
  std::optional<QueueEntryId> after;  // value 0: none
  std::optional<std::string> condition;
  std::optional<OnFailure> on_failure;
  std::optional<double> repeat_every_s;
  RunMetadata set_metadata;
  std::vector<std::string> remove_metadata;
};

struct QueueLine {
  QueueEntry entry;
  std::string waits_for;                     // a sentence; empty: it does not wait
  std::optional<EntryOutlook> outlook = {};  // none: it is over, or its trajectory is not read yet
};

struct QueueView {
  std::vector<QueueLine>
      lines;  // under way, waiting in their order, set aside, over (newest first)
  QueueHold hold;
};

class Queue {
 public:
  virtual ~Queue() = default;

  // All of it or nothing. The same request_id again answers with the first entry. Errors: those of
  // Trajectories::check; invalid_argument BAD_CONDITION, BAD_FOLLOW_UP, BAD_METADATA, BAD_REPEAT,
  // BAD_RULES, NOTHING_TO_COMPENSATE, NEEDS_COMPENSATION; not_found NO_SUCH_QUEUE_ENTRY,
  // NO_SUCH_MODEL; resource_exhausted QUEUE_FULL.
  virtual Awaitable<Result<QueueLine>> add(Caller caller, QueueDraft draft) = 0;
  // Errors of these three: not_found NO_SUCH_QUEUE_ENTRY; failed_precondition QUEUE_ENTRY_BEGUN (it
  // runs or is over); of change: those of add, QUEUE_CYCLE.
  virtual Awaitable<Result<QueueLine>> change(Caller caller, QueueEntryId id, QueueEdit edit) = 0;
  // Before another one, whose priority it takes; value 0: to the front; none: to the end. One that
  // was set aside waits again.
  virtual Awaitable<Result<QueueLine>> move(Caller caller, QueueEntryId id,
                                            std::optional<QueueEntryId> before) = 0;
  virtual Awaitable<Result<QueueLine>> remove(Caller caller, QueueEntryId id,
                                              std::string reason) = 0;
  virtual Awaitable<Result<QueueHold>> hold(Caller caller, std::string reason) = 0;
  // Errors: aborted STOPPED_MEANWHILE: it stays held by a stop that came beside;
  // failed_precondition STOP_PENDING: a stop is not confirmed, or not on record yet.
  virtual Awaitable<Result<void>> release(Caller caller) = 0;
  virtual QueueView list() const = 0;
  virtual Result<QueueLine> get(QueueEntryId id) const = 0;
};

}  // namespace driftwise::application
