#pragma once
// Targets: snapshots of the model that serves, and its corrections in the time before now.

#include <functional>
#include <memory>
#include <vector>

#include "server/compensation/snapshot_board.h"
#include "server/compensation/target.h"
#include "server/core/channel.h"
#include "server/core/ids.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

// A pose whose correction is wanted as it would have been in the time before now.
struct PastTargetsQuery {
  compensation::TargetRequest pose;  // now is not looked at
  Nanoseconds past = std::chrono::hours(1);
  int count = 120;  // of instants, about
};

struct PastTargets {
  struct Track {
    Channel channel;                    // of an output: q1_mm
    std::vector<double> correction_nm;  // per instant; kMissing: nothing was measured then
  };
  ModelId model;
  std::vector<CellTime> at;  // oldest first; none: the model reads nothing slow
  std::vector<Track> tracks;
};

class Targets {
 public:
  virtual ~Targets() = default;

  // The serving snapshot. Any thread; readers take no lock.
  virtual const compensation::SnapshotBoard& snapshots() const = 0;
  // Calls back at once and after every rebuild until the handle is destroyed. Executor's thread.
  virtual std::shared_ptr<void> watch_snapshots(std::function<void()> on_rebuilt) = 0;
  // Of the model that serves (past_targets.h), worked out on the reader's thread. Errors:
  // failed_precondition NO_MODEL; those of past_targets().
  virtual Awaitable<Result<PastTargets>> past(PastTargetsQuery query) const = 0;
};

}  // namespace driftwise::application
