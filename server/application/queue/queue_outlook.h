#pragma once
// Duration and end of each entry's run in the queue: bands, added up from the entry under way to
// the last. Pure. The draws of each entry's own run cost milliseconds: they are made elsewhere and
// kept (QueueDesk::draw_lengths), so that a list only adds them up.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "server/application/trajectories/outlook.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/queue_records.h"

namespace driftwise::application {

// An entry's own run, whatever is before it.
struct EntryLength {
  RunAhead ahead;
  std::shared_ptr<const DurationHistory> history;  // that run was drawn from; none: not drawn yet
  Outlook run;                                     // with its draws
};

// Without draws.
struct EntryOutlook {
  Outlook run;                 // from its start to its end; of a run under way: what is ahead
  std::optional<Outlook> end;  // from now; none: it, or one before it, waits for more than its turn
};

struct QueueAhead {
  const std::vector<QueueEntry>* entries = nullptr;
  bool held = false;    // the queue waits for a person
  bool stands = false;  // the run under way does
  CellTime now;
  std::function<CellTime(UtcTime)> cell_time;
  const std::map<QueueEntryId, EntryLength>* lengths = nullptr;  // of trajectories that were read
  std::optional<Outlook> under_way;  // of the run under way, with its draws
  std::optional<QueueEntryId> only;  // the one that is asked about; none: all of them
};

// The length of an entry is drawn from this and the history of the cell.
RunAhead run_ahead(const QueueEntry& entry, const PlanAhead& plan, const RunRules& cell_rules);

// An entry without draws has no outlook, and those behind it have no end. Those before the one that
// is asked about may be there too, with a duration only.
std::map<QueueEntryId, EntryOutlook> look_ahead(const QueueAhead& queue);

}  // namespace driftwise::application
