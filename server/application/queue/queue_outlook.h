#pragma once
// Duration and end of each entry's run in the queue: bands, drawn together from the entry under
// way to the last. Pure.

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "server/application/trajectories/outlook.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/queue_records.h"

namespace driftwise::application {

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
  std::map<QueueEntryId, PlanAhead> plans;  // of entries whose trajectory was read
  std::optional<Outlook> under_way;         // of the run under way, with its draws
  RunRules rules;                           // the cell's
};

std::map<QueueEntryId, EntryOutlook> look_ahead(const DurationHistory& history,
                                                const QueueAhead& queue);

}  // namespace driftwise::application
