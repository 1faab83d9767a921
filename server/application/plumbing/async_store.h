#pragma once
// The ports of server/core/ports/store.h for coroutines: each call is made on the store's thread
// and awaited, `co_await writer.runs().create_run(fresh)`. Functions, errors and durability are
// those of the ports. Parameters are values: a call owns what it works on.

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/signal.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

class AsyncStore;

class AsyncRunStore {
 public:
  explicit AsyncRunStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<RunRecord>> run(RunId run) const;
  Awaitable<Result<std::vector<RunRecord>>> runs(int limit, std::int64_t before_id) const;
  Awaitable<Result<RunRecord>> import_dataset(NewRun run, Dataset dataset) const;
  Awaitable<Result<RunRecord>> create_run(NewRun run) const;
  Awaitable<Result<void>> change_run(RunId run, RunChange change) const;

 private:
  AsyncStore& store_;
};

class AsyncPointStore {
 public:
  explicit AsyncPointStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::vector<PointRecord>>> points(RunId run, std::int64_t after_id,
                                                     int limit) const;
  Awaitable<Result<std::vector<AttemptRecord>>> attempts(RunId run) const;
  Awaitable<Result<std::vector<DatumRecord>>> data(RunId run) const;
  Awaitable<Result<std::optional<DatumRecord>>> newest_datum() const;
  Awaitable<Result<DatumId>> open_datum(DatumRecord datum) const;

 private:
  AsyncStore& store_;
};

class AsyncReadingStore {
 public:
  explicit AsyncReadingStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::vector<Reading>>> readings(std::string device, CellTime from, CellTime to,
                                                   int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncModelStore {
 public:
  explicit AsyncModelStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<ModelId>> add_model(ModelRecord model) const;
  Awaitable<Result<ModelRecord>> model(ModelId id) const;
  Awaitable<Result<std::vector<ModelRecord>>> models() const;
  Awaitable<Result<void>> add_promotion(PromotionRecord promotion) const;
  Awaitable<Result<std::vector<PromotionRecord>>> promotions() const;

 private:
  AsyncStore& store_;
};

class AsyncEventStore {
 public:
  explicit AsyncEventStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<EventId>> add_event(EventRecord event) const;
  Awaitable<Result<std::vector<EventRecord>>> events(EventId after, int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncRemarkStore {
 public:
  explicit AsyncRemarkStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<ExclusionRecord>> exclude(ExclusionRecord exclusion) const;
  Awaitable<Result<NoteRecord>> add_note(NoteRecord note) const;
  Awaitable<Result<std::vector<NoteRecord>>> notes(NoteSubject subject) const;
  Awaitable<Result<TimeNoteRecord>> add_time_note(TimeNoteRecord note) const;
  Awaitable<Result<std::vector<TimeNoteRecord>>> time_notes(CellTime from, CellTime to,
                                                            int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncDiagnosisStore {
 public:
  explicit AsyncDiagnosisStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<DiagnosisRecord>> add_diagnosis(DiagnosisRecord diagnosis) const;
  Awaitable<Result<void>> end_diagnosis(DiagnosisId id, DiagnosisEnd end) const;

 private:
  AsyncStore& store_;
};

class AsyncExtensionStore {
 public:
  explicit AsyncExtensionStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::vector<CorrectionRecord>>> corrections() const;
  Awaitable<Result<ExtensionRecord>> accept(NewExtension extension) const;
  Awaitable<Result<ExtensionRecord>> undo_extension(
      DiagnosisId id, Stamp at, std::string who, std::string from,
      std::optional<PromotionRecord> rollback = {}) const;

 private:
  AsyncStore& store_;
};

class AsyncImprovementStore {
 public:
  explicit AsyncImprovementStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<ImprovementRecord>> add_improvement(ImprovementRecord improvement) const;
  Awaitable<Result<void>> put_turn(ImprovementId id, ImprovementTurn turn) const;
  Awaitable<Result<void>> end_improvement(ImprovementId id, JobState state, std::string reason,
                                          CellTime at) const;
  Awaitable<Result<ImprovementRecord>> improvement(ImprovementId id) const;
  Awaitable<Result<std::vector<ImprovementRecord>>> improvements(int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncRecordStore {
 public:
  explicit AsyncRecordStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<RecordPage>> records(RecordCursor after, RecordCursor until, int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncAlarmStore {
 public:
  explicit AsyncAlarmStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<AlarmRecord>> raise(AlarmRecord alarm) const;
  Awaitable<Result<AlarmRecord>> tell(AlarmId id, std::string message,
                                      std::vector<std::string> consequences) const;
  Awaitable<Result<AlarmRecord>> clear(AlarmId id, CellTime at) const;
  Awaitable<Result<AlarmRecord>> acknowledge(AlarmId id, CellTime at, std::string who) const;
  Awaitable<Result<std::vector<AlarmRecord>>> alarms(bool with_history, int limit) const;
  Awaitable<Result<AlarmRecord>> shelve(AlarmId id, AlarmShelf shelf) const;
  Awaitable<Result<AlarmRecord>> unshelve(AlarmId id, CellTime at) const;
  Awaitable<Result<std::vector<AlarmRecord>>> end_shelves(CellTime now) const;

 private:
  AsyncStore& store_;
};

class AsyncOutboxStore {
 public:
  explicit AsyncOutboxStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<OpenTellings>> open(std::vector<std::string> receivers, CellTime now,
                                       CellTime over_after) const;
  Awaitable<Result<void>> put(std::vector<TellingRecord> tellings) const;
  Awaitable<Result<std::vector<TellingRecord>>> tellings(int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncSeriesStore {
 public:
  explicit AsyncSeriesStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<SeriesAnswer>> series(SeriesQuery query) const;

 private:
  AsyncStore& store_;
};

class AsyncTrajectoryStore {
 public:
  explicit AsyncTrajectoryStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<KeptTrajectory>> keep(KeptTrajectory trajectory) const;
  Awaitable<Result<KeptTrajectory>> trajectory(TrajectoryId id) const;
  Awaitable<Result<std::vector<KeptTrajectory>>> trajectories() const;

 private:
  AsyncStore& store_;
};

class AsyncStopStore {
 public:
  explicit AsyncStopStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::vector<StopRecord>>> keep(std::vector<StopRecord> stops) const;
  Awaitable<Result<bool>> confirm(StopRecord stop, CellTime at) const;

 private:
  AsyncStore& store_;
};

class AsyncClosureStore {
 public:
  explicit AsyncClosureStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::int64_t>> add_closure(ClosureRecord closure,
                                              std::optional<RepeatedLine> repeated) const;
  Awaitable<Result<std::vector<ClosureRecord>>> closures(RunId run) const;
  Awaitable<Result<std::vector<PointId>>> repeated_points(RunId run) const;

 private:
  AsyncStore& store_;
};

class AsyncRestStore {
 public:
  explicit AsyncRestStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::int64_t>> begin_rest(RestRecord rest) const;
  Awaitable<Result<void>> end_rest(std::int64_t id, CellTime at, std::string reason) const;
  Awaitable<Result<std::optional<RestRecord>>> newest_rest() const;

 private:
  AsyncStore& store_;
};

class AsyncClockStore {
 public:
  explicit AsyncClockStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<void>> add_clock(ClockRecord record) const;

 private:
  AsyncStore& store_;
};

class AsyncConfigurationStore {
 public:
  explicit AsyncConfigurationStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<std::vector<ConfigurationStart>>> starts(int limit) const;
  Awaitable<Result<ConfigurationStart>> accept(std::int64_t start, CellTime at, std::string who,
                                               std::string note,
                                               std::optional<RunId> continued) const;
  Awaitable<Result<void>> continue_run(RunId run, UsedConfiguration used) const;

 private:
  AsyncStore& store_;
};

class AsyncAuditStore {
 public:
  explicit AsyncAuditStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<AuditRecord>> add(AuditRecord act, std::optional<EventRecord> event) const;
  Awaitable<Result<std::vector<AuditRecord>>> acts(std::int64_t before_id, int limit) const;
  Awaitable<Result<ChainHead>> head() const;

 private:
  AsyncStore& store_;
};

class AsyncQueueStore {
 public:
  explicit AsyncQueueStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<QueueRecord>> queue(int history) const;
  Awaitable<Result<void>> change_queue(QueueChange change) const;

 private:
  AsyncStore& store_;
};

class AsyncMetadataStore {
 public:
  explicit AsyncMetadataStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<RunRecord>> tag(RunId run, RunMetadata set,
                                   std::vector<std::string> removed) const;
  Awaitable<Result<std::vector<RunRecord>>> find_runs(RunMetadata all_of, int limit,
                                                      std::int64_t before_id) const;

 private:
  AsyncStore& store_;
};

class AsyncIndentationStore {
 public:
  explicit AsyncIndentationStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<IndentationRecord>> add_indentation(IndentationRecord record) const;
  Awaitable<Result<void>> change_indentation(IndentationRecord record) const;
  Awaitable<Result<IndentationRecord>> indentation(IndentationId id) const;
  Awaitable<Result<std::vector<IndentationRecord>>> indentations(int limit) const;

 private:
  AsyncStore& store_;
};

class AsyncPlanStore {
 public:
  explicit AsyncPlanStore(AsyncStore& store) : store_(store) {}
  Awaitable<Result<PlanRecord>> add_plan(PlanRecord plan) const;
  Awaitable<Result<PlanRecord>> plan(PlanId id) const;
  Awaitable<Result<std::vector<PlanRecord>>> plans() const;
  Awaitable<Result<void>> add_plan_promotion(PlanPromotionRecord promotion) const;
  Awaitable<Result<std::vector<PlanPromotionRecord>>> plan_promotions() const;

 private:
  AsyncStore& store_;
};

// One store and the one thread that may touch it.
class AsyncStore {
 public:
  AsyncRunStore runs() { return AsyncRunStore(*this); }
  AsyncPointStore points() { return AsyncPointStore(*this); }
  AsyncReadingStore readings() { return AsyncReadingStore(*this); }
  AsyncModelStore models() { return AsyncModelStore(*this); }
  AsyncEventStore events() { return AsyncEventStore(*this); }
  AsyncRemarkStore remarks() { return AsyncRemarkStore(*this); }
  AsyncDiagnosisStore diagnoses() { return AsyncDiagnosisStore(*this); }
  AsyncExtensionStore extensions() { return AsyncExtensionStore(*this); }
  AsyncImprovementStore improvements() { return AsyncImprovementStore(*this); }
  AsyncRecordStore records() { return AsyncRecordStore(*this); }
  AsyncAlarmStore alarms() { return AsyncAlarmStore(*this); }
  AsyncOutboxStore outbox() { return AsyncOutboxStore(*this); }
  AsyncSeriesStore series() { return AsyncSeriesStore(*this); }
  AsyncTrajectoryStore trajectories() { return AsyncTrajectoryStore(*this); }
  AsyncStopStore stops() { return AsyncStopStore(*this); }
  AsyncClosureStore closures() { return AsyncClosureStore(*this); }
  AsyncRestStore rests() { return AsyncRestStore(*this); }
  AsyncClockStore clocks() { return AsyncClockStore(*this); }
  AsyncConfigurationStore configurations() { return AsyncConfigurationStore(*this); }
  AsyncAuditStore audit() { return AsyncAuditStore(*this); }
  AsyncQueueStore queue() { return AsyncQueueStore(*this); }
  AsyncMetadataStore metadata() { return AsyncMetadataStore(*this); }
  AsyncPlanStore plans() { return AsyncPlanStore(*this); }
  AsyncIndentationStore indentations() { return AsyncIndentationStore(*this); }

  // Several calls of the store in one go: function(store, arguments...) on its thread. The rules
  // for closures and arguments are those of run_on().
  template <class Function, class... Arguments>
  Awaitable<std::invoke_result_t<Function&, Store&, std::decay_t<Arguments>&...>> call(
      Function function, Arguments&&... arguments) {
    static_assert(std::is_trivially_copyable_v<Function>,
                  "the closure owns something: give it as an argument of call");
    return when_open(function, std::decay_t<Arguments>(std::forward<Arguments>(arguments))...);
  }

 protected:
  // executor: that of the coroutines which call.
  AsyncStore(const asio::any_io_executor& executor, asio::any_io_executor thread,
             std::unique_ptr<Store> store);
  ~AsyncStore();

  asio::any_io_executor thread_;
  std::unique_ptr<Store> store_;
  bool suspended_ = false;  // calls wait for resumed_
  Signal resumed_;

 private:
  template <class Function, class... Owned>
  Awaitable<std::invoke_result_t<Function&, Store&, Owned&...>> when_open(Function function,
                                                                          Owned... owned) {
    while (suspended_) co_await resumed_.wait();
    auto calling = run_on(
        thread_,
        [this, function](Owned&... arguments) mutable { return function(*store_, arguments...); },
        std::move(owned)...);
    co_return co_await std::move(calling);
  }
};

}  // namespace driftwise::application
