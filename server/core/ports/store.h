#pragma once
// What the daemon asks of a database. Calls block; each object belongs to one thread: the
// application keeps the writing store on its writer thread and opens a second, read-only one for
// queries. Errors: resource_exhausted (full disk; nothing was written, the call may be repeated),
// data_loss (damaged file), not_found, failed_precondition (schema newer than this program),
// internal.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/ports/audit_store.h"
#include "server/core/ports/clock_store.h"
#include "server/core/ports/configuration_store.h"
#include "server/core/ports/diagnosis_store.h"
#include "server/core/ports/outside/outbox_store.h"
#include "server/core/ports/queue_store.h"
#include "server/core/ports/record/closure_store.h"
#include "server/core/ports/record/indentation_store.h"
#include "server/core/ports/record/rest_store.h"
#include "server/core/ports/serving/plan_store.h"
#include "server/core/ports/stop_store.h"
#include "server/core/ports/upkeep_store.h"
#include "server/core/ports/watch_store.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise {

class RunStore {
 public:
  virtual ~RunStore() = default;
  // Queued; paused, with the stop's cause as its reason, when a stop was asked for at
  // NewRun::created or later.
  virtual Result<RunRecord> create_run(const NewRun& run) = 0;
  virtual Result<void> change_run(RunId run, const RunChange& change) = 0;
  virtual Result<RunRecord> run(RunId run) = 0;
  // Newest first, without the texts of their trajectories: run() has that.
  virtual Result<std::vector<RunRecord>> runs(int limit,
                                              std::int64_t before_id /* 0: newest */) = 0;
  virtual Result<std::optional<RunRecord>>
  unfinished_run() = 0;  // running, paused, waiting: to go on with after a restart
  // A dataset that was measured elsewhere becomes a run, done, in one transaction. The file's own
  // run and datum numbers, columns, order and metadata are kept: dataset() of this run alone gives
  // it back exactly. Errors: invalid_argument BAD_CHANNEL, BAD_DATASET (columns of unequal length);
  // resource_exhausted TOO_MANY_CHANNELS (new names beyond 1000).
  virtual Result<RunRecord> import_dataset(const NewRun& run, const Dataset& dataset) = 0;
  // Accepted points of the runs, in time order, as the dataset CSV has them. time_s starts at the
  // first point; an imported run has no instants of its own and follows after the measured ones.
  // Columns: q, q_cmd, pose, _std_, structure temperatures, others. run and datum are given where
  // there is more than one of them, excluded where a row is. metadata: that of the file when it is
  // one imported run; of several, what they state together (core/data/stated_lines.h); else none.
  // Errors: not_found NO_SUCH_RUN; invalid_argument BAD_RUNS, METADATA_DISAGREE, UNITS_DISAGREE
  // (one of the runs gives a symbol in a unit that another run does not).
  virtual Result<Dataset> dataset(std::span<const RunId> runs) = 0;
};

// What is measured in a run, as it comes. Errors: not_found NO_SUCH_RUN.
class PointStore {
 public:
  virtual ~PointStore() = default;
  virtual Result<DatumId> open_datum(const DatumRecord& datum) = 0;
  // Durable (WAL, synchronous FULL) when it returns; all of it or nothing. A row that has its
  // point, or an attempt that is stored, is refused with already_exists, ALREADY_STORED: what a
  // repeat meets whose first try got through.
  virtual Result<std::optional<PointId>> commit(const PointCommit& commit) = 0;

  virtual Result<std::vector<PointRecord>> points(RunId run, std::int64_t after_id, int limit) = 0;
  virtual Result<std::vector<AttemptRecord>> attempts(RunId run) = 0;  // without their readings
  virtual Result<std::vector<DatumRecord>> data(RunId run) = 0;        // datums, oldest first
  // The last one opened on this cell, in a run or by hand; not that of an imported dataset.
  virtual Result<std::optional<DatumRecord>> newest_datum() = 0;
};

class ReadingStore {
 public:
  virtual ~ReadingStore() = default;
  // rejected: values of these or other readings.
  virtual Result<void> append(std::span<const Reading> readings, std::span<const MoveRecord> moves,
                              std::span<const RejectedAnswer> rejected = {}) = 0;
  // In time order, start in [from, to); device empty: all. limit: of more than that the newest;
  // 0: every one. A value that was rejected reads as kMissing: nothing computes with it.
  virtual Result<std::vector<Reading>> readings(const std::string& device, CellTime from,
                                                CellTime to, int limit) = 0;
  virtual Result<std::vector<MoveRecord>> moves(CellTime from, CellTime to) = 0;
};

class ModelStore {
 public:
  virtual ~ModelStore() = default;
  virtual Result<ModelId> add_model(
      const ModelRecord& model) = 0;  // its id is ignored; same hash again: same id
  virtual Result<ModelRecord> model(ModelId id) = 0;
  virtual Result<std::vector<ModelRecord>> models() = 0;
  virtual Result<void> add_promotion(const PromotionRecord& promotion) = 0;
  virtual Result<std::vector<PromotionRecord>>
  promotions() = 0;  // oldest first; the last one serves
};

class EventStore {
 public:
  virtual ~EventStore() = default;
  virtual Result<EventId> add_event(const EventRecord& event) = 0;
  virtual Result<std::vector<EventRecord>> events(EventId after, int limit) = 0;
};

// What people say about the record; nothing here changes what was measured.
class RemarkStore {
 public:
  virtual ~RemarkStore() = default;
  // Keeps the rows that this changes (in when excluded, out when put back) and answers with them;
  // with none it stores nothing and the id is 0. Errors: not_found NO_SUCH_RUN; invalid_argument
  // NO_SUCH_ROW (a row without an accepted point).
  virtual Result<ExclusionRecord> exclude(const ExclusionRecord& exclusion) = 0;
  virtual Result<std::vector<ExclusionRecord>> exclusions(RunId run) = 0;  // oldest first
  // Answers with the note as stored. Errors: not_found NO_SUCH_RUN, NO_SUCH_MODEL; invalid_argument
  // NO_SUCH_ROW, BAD_SUBJECT (neither or both of run and model).
  virtual Result<NoteRecord> add_note(const NoteRecord& note) = 0;
  // Oldest first. Of a run: also those on its points, unless the subject names one.
  virtual Result<std::vector<NoteRecord>> notes(const NoteSubject& subject) = 0;
  // Answers with the note as stored; the same request again: with the first one.
  virtual Result<TimeNoteRecord> add_time_note(const TimeNoteRecord& note) = 0;
  // About instants in [from, to), newest first.
  virtual Result<std::vector<TimeNoteRecord>> time_notes(CellTime from, CellTime to, int limit) = 0;
};

// The parts of one store: none is nullptr but upkeep, which a store without files of its own lacks.
struct StoreParts {
  RunStore* runs = nullptr;
  PointStore* points = nullptr;
  ReadingStore* readings = nullptr;
  ModelStore* models = nullptr;
  EventStore* events = nullptr;
  RemarkStore* remarks = nullptr;
  DiagnosisStore* diagnoses = nullptr;
  ExtensionStore* extensions = nullptr;
  ImprovementStore* improvements = nullptr;
  RecordStore* records = nullptr;
  AlarmStore* alarms = nullptr;
  OutboxStore* outbox = nullptr;
  SeriesStore* series = nullptr;
  TrajectoryStore* trajectories = nullptr;
  StopStore* stops = nullptr;
  ClockStore* clocks = nullptr;
  ClosureStore* closures = nullptr;
  RestStore* rests = nullptr;
  ConfigurationStore* configurations = nullptr;
  AuditStore* audit = nullptr;
  QueueStore* queue = nullptr;
  MetadataStore* metadata = nullptr;
  PlanStore* plans = nullptr;
  IndentationStore* indentations = nullptr;
  UpkeepStore* upkeep = nullptr;
};

// One database. Its parts share its transactions and its thread.
class Store {
 public:
  virtual ~Store() = default;
  RunStore& runs() { return *parts_.runs; }
  PointStore& points() { return *parts_.points; }
  ReadingStore& readings() { return *parts_.readings; }
  ModelStore& models() { return *parts_.models; }
  EventStore& events() { return *parts_.events; }
  RemarkStore& remarks() { return *parts_.remarks; }
  DiagnosisStore& diagnoses() { return *parts_.diagnoses; }
  ExtensionStore& extensions() { return *parts_.extensions; }
  ImprovementStore& improvements() { return *parts_.improvements; }
  RecordStore& records() { return *parts_.records; }
  AlarmStore& alarms() { return *parts_.alarms; }
  OutboxStore& outbox() { return *parts_.outbox; }
  SeriesStore& series() { return *parts_.series; }
  TrajectoryStore& trajectories() { return *parts_.trajectories; }
  StopStore& stops() { return *parts_.stops; }
  ClockStore& clocks() { return *parts_.clocks; }
  ClosureStore& closures() { return *parts_.closures; }
  RestStore& rests() { return *parts_.rests; }
  ConfigurationStore& configurations() { return *parts_.configurations; }
  AuditStore& audit() { return *parts_.audit; }
  QueueStore& queue() { return *parts_.queue; }
  MetadataStore& metadata() { return *parts_.metadata; }
  PlanStore& plans() { return *parts_.plans; }
  IndentationStore& indentations() { return *parts_.indentations; }
  UpkeepStore* upkeep() { return parts_.upkeep; }
  // For a store that stands before another and answers some parts itself.
  const StoreParts& parts() const { return parts_; }

  // Housekeeping that must not delay a point (SQLite: a checkpoint of the log, a step of the
  // summaries): call it on the store's thread when there is time, between points; it does nothing
  // when there is nothing to do. An error costs no data.
  virtual Result<void> idle() { return {}; }

 protected:
  explicit Store(const StoreParts& parts) : parts_(parts) {}

 private:
  StoreParts parts_;
};

using OpenStore =
    std::function<Result<std::unique_ptr<Store>>(const std::string& path, bool read_only)>;

}  // namespace driftwise
