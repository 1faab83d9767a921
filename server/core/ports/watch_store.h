#pragma once
// What a database gives to those who watch. As server/core/ports/store.h: calls block, one thread.

#include <string>
#include <vector>

#include "server/core/records/watch_records.h"
#include "server/core/result.h"

namespace driftwise {

// The record after a cursor, whatever its kind.
class RecordStore {
 public:
  virtual ~RecordStore() = default;
  // Made with the database: a cursor of another one means nothing here.
  virtual Result<std::string> database_id() = 0;
  virtual Result<RecordCursor> newest() = 0;
  // After one cursor and up to the other, at most limit of each kind (page.to says how far).
  virtual Result<RecordPage> records(const RecordCursor& after, const RecordCursor& until,
                                     int limit) = 0;
};

class AlarmStore {
 public:
  virtual ~AlarmStore() = default;
  virtual Result<AlarmRecord> raise(const AlarmRecord& alarm) = 0;  // its id is ignored
  // Its sentence and its consequences now. Errors of all below: not_found NO_SUCH_ALARM.
  virtual Result<AlarmRecord> tell(AlarmId id, const std::string& message,
                                   const std::vector<std::string>& consequences) = 0;
  // Done before: as it was.
  virtual Result<AlarmRecord> clear(AlarmId id, CellTime at) = 0;
  virtual Result<AlarmRecord> acknowledge(AlarmId id, CellTime at, const std::string& who) = 0;
  // Newest first; limit 0: all. Without history: those that still hold or nobody has acknowledged.
  virtual Result<std::vector<AlarmRecord>> alarms(bool with_history, int limit) = 0;
  // Shelves the condition of this alarm; a shelf that stands is replaced.
  virtual Result<AlarmRecord> shelve(AlarmId id, const AlarmShelf& shelf) = 0;
  virtual Result<AlarmRecord> unshelve(AlarmId id, CellTime at) = 0;
  // Ends the shelves whose time is over. Result: the alarms that hold or nobody has acknowledged,
  // which come back.
  virtual Result<std::vector<AlarmRecord>> end_shelves(CellTime now) = 0;
};

class SeriesStore {
 public:
  virtual ~SeriesStore() = default;
  // A channel that was never recorded has an empty column, which says so. Errors: not_found
  // NO_SUCH_RUN.
  virtual Result<SeriesAnswer> series(const SeriesQuery& query) = 0;
  // Takes some of the readings stored since the last time into the summaries that make series()
  // quick. True: there are more. Costs about 20 ms.
  virtual Result<bool> summarise() = 0;
};

class TrajectoryStore {
 public:
  virtual ~TrajectoryStore() = default;
  virtual Result<KeptTrajectory> keep(
      const KeptTrajectory& trajectory) = 0;                       // same text: the first one
  virtual Result<KeptTrajectory> trajectory(TrajectoryId id) = 0;  // not_found NO_SUCH_TRAJECTORY
  virtual Result<std::vector<KeptTrajectory>> trajectories() = 0;  // newest first, without texts
};

}  // namespace driftwise
