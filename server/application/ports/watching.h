#pragma once
// What those who stay and watch ask of the cell: the record after a cursor, alarms, series, and
// trajectories kept for later. A part of Cell (cell.h), whose thread and errors it shares.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/compensation/target.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/watch_records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct Caller;

struct RecordHead {
  std::string database;  // its own name
  RecordCursor newest;
};

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

class Watching {
 public:
  virtual ~Watching() = default;

  virtual Awaitable<Result<RecordHead>> record_head() = 0;
  // At most limit records of each kind; the page says how far it got.
  virtual Awaitable<Result<RecordPage>> records(RecordCursor after, RecordCursor until,
                                                int limit) = 0;
  // Calls back when there is something new in the record, whatever it is.
  virtual std::shared_ptr<void> watch_records(std::function<void()> on_news) = 0;

  // Newest first. Without history: those that still hold or nobody has acknowledged.
  virtual Awaitable<Result<std::vector<AlarmRecord>>> alarms(bool with_history, int limit) = 0;
  // Errors: not_found NO_SUCH_ALARM.
  virtual Awaitable<Result<AlarmRecord>> acknowledge_alarm(Caller caller, AlarmId id) = 0;

  // Errors: those of SeriesStore::series.
  virtual Awaitable<Result<SeriesAnswer>> series(SeriesQuery query) = 0;
  // Of the model that serves. Errors: failed_precondition NO_MODEL; those of past_targets().
  virtual Awaitable<Result<PastTargets>> past_targets(PastTargetsQuery query) = 0;

  // Checked as Cell::check_trajectory does. The same text again: the first one.
  virtual Awaitable<Result<KeptTrajectory>> keep_trajectory(Caller caller, std::string name,
                                                            std::string text) = 0;
  virtual Awaitable<Result<KeptTrajectory>> trajectory(TrajectoryId id) = 0;
  virtual Awaitable<Result<std::vector<KeptTrajectory>>> trajectories() = 0;
};

}  // namespace driftwise::application
