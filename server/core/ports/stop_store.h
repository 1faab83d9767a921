#pragma once
// Stops as the database keeps them. As server/core/ports/store.h: calls block, one thread.

#include <span>
#include <string>
#include <vector>

#include "server/core/records/stop_record.h"
#include "server/core/result.h"

namespace driftwise {

class StopStore {
 public:
  virtual ~StopStore() = default;
  // In one transaction: each controller has a pending stop, and a run that is running, waiting or,
  // as the newest of all, queued has the state paused with the first stop's cause as its reason. A
  // run that create_run() stores later is paused there. A stop that is pending already
  // keeps its person and its instant; its cause and its number of presses are replaced. Ids are
  // ignored. Result: the pending stops as stored.
  virtual Result<std::vector<StopRecord>> keep(std::span<const StopRecord> stops) = 0;
  // Ends the controller's pending stop, where it has not been pressed again since (presses), and
  // pauses the run as keep() does. False: it was pressed again, or none is pending.
  virtual Result<bool> confirm(const StopRecord& stop, CellTime at) = 0;
  virtual Result<std::vector<StopRecord>> pending() = 0;  // oldest first
};

}  // namespace driftwise
