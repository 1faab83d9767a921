#include "server/application/plumbing/async_store.h"

#include "server/application/plumbing/crash_point.h"

namespace driftwise::application {
namespace {

// One call of one part of the store.
template <auto part, auto method, class... Owned>
auto ask(AsyncStore& store, Owned... owned) {
  return store.call(
      [](Store& whole, Owned&... arguments) { return ((whole.*part)().*method)(arguments...); },
      std::move(owned)...);
}

// The same for a commit whose durability a test judges: docs/crash-points.md.
template <auto part, auto method, class... Owned>
auto commit(AsyncStore& store, const char* before, const char* after, Owned... owned) {
  return store.call(
      [before, after](Store& whole, Owned&... arguments) {
        crash_point(before);
        auto result = ((whole.*part)().*method)(arguments...);
        if (result) crash_point(after);
        return result;
      },
      std::move(owned)...);
}

}  // namespace

AsyncStore::AsyncStore(const asio::any_io_executor& executor, asio::any_io_executor thread,
                       std::unique_ptr<Store> store)
    : thread_(std::move(thread)), store_(std::move(store)), resumed_(executor) {}

AsyncStore::~AsyncStore() = default;

Awaitable<Result<RunRecord>> AsyncRunStore::run(RunId run) const {
  return ask<&Store::runs, &RunStore::run>(store_, run);
}

Awaitable<Result<std::vector<RunRecord>>> AsyncRunStore::runs(int limit,
                                                              std::int64_t before_id) const {
  return ask<&Store::runs, &RunStore::runs>(store_, limit, before_id);
}

Awaitable<Result<std::vector<PointRecord>>> AsyncPointStore::points(RunId run,
                                                                    std::int64_t after_id,
                                                                    int limit) const {
  return ask<&Store::points, &PointStore::points>(store_, run, after_id, limit);
}

Awaitable<Result<std::vector<AttemptRecord>>> AsyncPointStore::attempts(RunId run) const {
  return ask<&Store::points, &PointStore::attempts>(store_, run);
}

Awaitable<Result<std::vector<DatumRecord>>> AsyncPointStore::data(RunId run) const {
  return ask<&Store::points, &PointStore::data>(store_, run);
}

Awaitable<Result<std::optional<DatumRecord>>> AsyncPointStore::newest_datum() const {
  return ask<&Store::points, &PointStore::newest_datum>(store_);
}

Awaitable<Result<RunRecord>> AsyncRunStore::import_dataset(NewRun run, Dataset dataset) const {
  return ask<&Store::runs, &RunStore::import_dataset>(store_, std::move(run), std::move(dataset));
}

Awaitable<Result<RunRecord>> AsyncRunStore::create_run(NewRun run) const {
  return commit<&Store::runs, &RunStore::create_run>(store_, "before_run_create_commit",
                                                     "after_run_create_commit", std::move(run));
}

Awaitable<Result<DatumId>> AsyncPointStore::open_datum(DatumRecord datum) const {
  return commit<&Store::points, &PointStore::open_datum>(store_, "before_datum_commit",
                                                         "after_datum_commit", std::move(datum));
}

Awaitable<Result<void>> AsyncRunStore::change_run(RunId run, RunChange change) const {
  return commit<&Store::runs, &RunStore::change_run>(
      store_, "before_run_state_commit", "after_run_state_commit", run, std::move(change));
}

Awaitable<Result<std::vector<Reading>>> AsyncReadingStore::readings(std::string device,
                                                                    CellTime from, CellTime to,
                                                                    int limit) const {
  return ask<&Store::readings, &ReadingStore::readings>(store_, std::move(device), from, to, limit);
}

Awaitable<Result<ModelId>> AsyncModelStore::add_model(ModelRecord model) const {
  return commit<&Store::models, &ModelStore::add_model>(store_, "before_model_commit",
                                                        "after_model_commit", std::move(model));
}

Awaitable<Result<ModelRecord>> AsyncModelStore::model(ModelId id) const {
  return ask<&Store::models, &ModelStore::model>(store_, id);
}

Awaitable<Result<std::vector<ModelRecord>>> AsyncModelStore::models() const {
  return ask<&Store::models, &ModelStore::models>(store_);
}

Awaitable<Result<void>> AsyncModelStore::add_promotion(PromotionRecord promotion) const {
  return commit<&Store::models, &ModelStore::add_promotion>(
      store_, "before_promotion_commit", "after_promotion_commit", std::move(promotion));
}

Awaitable<Result<std::vector<PromotionRecord>>> AsyncModelStore::promotions() const {
  return ask<&Store::models, &ModelStore::promotions>(store_);
}

Awaitable<Result<EventId>> AsyncEventStore::add_event(EventRecord event) const {
  return commit<&Store::events, &EventStore::add_event>(store_, "before_event_commit",
                                                        "after_event_commit", std::move(event));
}

Awaitable<Result<std::vector<EventRecord>>> AsyncEventStore::events(EventId after,
                                                                    int limit) const {
  return ask<&Store::events, &EventStore::events>(store_, after, limit);
}

Awaitable<Result<ExclusionRecord>> AsyncRemarkStore::exclude(ExclusionRecord exclusion) const {
  return ask<&Store::remarks, &RemarkStore::exclude>(store_, std::move(exclusion));
}

Awaitable<Result<NoteRecord>> AsyncRemarkStore::add_note(NoteRecord note) const {
  return ask<&Store::remarks, &RemarkStore::add_note>(store_, std::move(note));
}

Awaitable<Result<std::vector<NoteRecord>>> AsyncRemarkStore::notes(NoteSubject subject) const {
  return ask<&Store::remarks, &RemarkStore::notes>(store_, std::move(subject));
}

Awaitable<Result<TimeNoteRecord>> AsyncRemarkStore::add_time_note(TimeNoteRecord note) const {
  return ask<&Store::remarks, &RemarkStore::add_time_note>(store_, std::move(note));
}

Awaitable<Result<std::vector<TimeNoteRecord>>> AsyncRemarkStore::time_notes(CellTime from,
                                                                            CellTime to,
                                                                            int limit) const {
  return ask<&Store::remarks, &RemarkStore::time_notes>(store_, from, to, limit);
}

Awaitable<Result<DiagnosisRecord>> AsyncDiagnosisStore::add_diagnosis(
    DiagnosisRecord diagnosis) const {
  return ask<&Store::diagnoses, &DiagnosisStore::add_diagnosis>(store_, std::move(diagnosis));
}

Awaitable<Result<void>> AsyncDiagnosisStore::end_diagnosis(DiagnosisId id, DiagnosisEnd end) const {
  return ask<&Store::diagnoses, &DiagnosisStore::end_diagnosis>(store_, id, std::move(end));
}

Awaitable<Result<std::vector<CorrectionRecord>>> AsyncExtensionStore::corrections() const {
  return ask<&Store::extensions, &ExtensionStore::corrections>(store_);
}

Awaitable<Result<ExtensionRecord>> AsyncExtensionStore::accept(NewExtension extension) const {
  return commit<&Store::extensions, &ExtensionStore::accept>(
      store_, "before_extension_commit", "after_extension_commit", std::move(extension));
}

Awaitable<Result<ExtensionRecord>> AsyncExtensionStore::undo_extension(
    DiagnosisId id, Stamp at, std::string who, std::string from,
    std::optional<PromotionRecord> rollback) const {
  return commit<&Store::extensions, &ExtensionStore::undo_extension>(
      store_, "before_undo_commit", "after_undo_commit", id, at, std::move(who), std::move(from),
      std::move(rollback));
}

Awaitable<Result<ImprovementRecord>> AsyncImprovementStore::add_improvement(
    ImprovementRecord improvement) const {
  return ask<&Store::improvements, &ImprovementStore::add_improvement>(store_,
                                                                       std::move(improvement));
}

Awaitable<Result<void>> AsyncImprovementStore::put_turn(ImprovementId id,
                                                        ImprovementTurn turn) const {
  return ask<&Store::improvements, &ImprovementStore::put_turn>(store_, id, std::move(turn));
}

Awaitable<Result<void>> AsyncImprovementStore::end_improvement(ImprovementId id, JobState state,
                                                               std::string reason,
                                                               CellTime at) const {
  return ask<&Store::improvements, &ImprovementStore::end_improvement>(store_, id, state,
                                                                       std::move(reason), at);
}

Awaitable<Result<ImprovementRecord>> AsyncImprovementStore::improvement(ImprovementId id) const {
  return ask<&Store::improvements, &ImprovementStore::improvement>(store_, id);
}

Awaitable<Result<std::vector<ImprovementRecord>>> AsyncImprovementStore::improvements(
    int limit) const {
  return ask<&Store::improvements, &ImprovementStore::improvements>(store_, limit);
}

Awaitable<Result<RecordPage>> AsyncRecordStore::records(RecordCursor after, RecordCursor until,
                                                        int limit) const {
  return ask<&Store::records, &RecordStore::records>(store_, after, until, limit);
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::raise(AlarmRecord alarm) const {
  return ask<&Store::alarms, &AlarmStore::raise>(store_, std::move(alarm));
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::tell(AlarmId id, std::string message,
                                                     std::vector<std::string> consequences) const {
  return ask<&Store::alarms, &AlarmStore::tell>(store_, id, std::move(message),
                                                std::move(consequences));
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::clear(AlarmId id, CellTime at) const {
  return ask<&Store::alarms, &AlarmStore::clear>(store_, id, at);
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::acknowledge(AlarmId id, CellTime at,
                                                            std::string who) const {
  return ask<&Store::alarms, &AlarmStore::acknowledge>(store_, id, at, std::move(who));
}

Awaitable<Result<std::vector<AlarmRecord>>> AsyncAlarmStore::alarms(bool with_history,
                                                                    int limit) const {
  return ask<&Store::alarms, &AlarmStore::alarms>(store_, with_history, limit);
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::shelve(AlarmId id, AlarmShelf shelf) const {
  return ask<&Store::alarms, &AlarmStore::shelve>(store_, id, std::move(shelf));
}

Awaitable<Result<AlarmRecord>> AsyncAlarmStore::unshelve(AlarmId id, CellTime at) const {
  return ask<&Store::alarms, &AlarmStore::unshelve>(store_, id, at);
}

Awaitable<Result<std::vector<AlarmRecord>>> AsyncAlarmStore::end_shelves(CellTime now) const {
  return ask<&Store::alarms, &AlarmStore::end_shelves>(store_, now);
}

Awaitable<Result<OpenTellings>> AsyncOutboxStore::open(std::vector<std::string> receivers,
                                                       CellTime now, CellTime over_after) const {
  return ask<&Store::outbox, &OutboxStore::open>(store_, std::move(receivers), now, over_after);
}

Awaitable<Result<void>> AsyncOutboxStore::put(std::vector<TellingRecord> tellings) const {
  return ask<&Store::outbox, &OutboxStore::put>(store_, std::move(tellings));
}

Awaitable<Result<std::vector<TellingRecord>>> AsyncOutboxStore::tellings(int limit) const {
  return ask<&Store::outbox, &OutboxStore::tellings>(store_, limit);
}

Awaitable<Result<SeriesAnswer>> AsyncSeriesStore::series(SeriesQuery query) const {
  return ask<&Store::series, &SeriesStore::series>(store_, std::move(query));
}

Awaitable<Result<KeptTrajectory>> AsyncTrajectoryStore::keep(KeptTrajectory trajectory) const {
  return ask<&Store::trajectories, &TrajectoryStore::keep>(store_, std::move(trajectory));
}

Awaitable<Result<KeptTrajectory>> AsyncTrajectoryStore::trajectory(TrajectoryId id) const {
  return ask<&Store::trajectories, &TrajectoryStore::trajectory>(store_, id);
}

Awaitable<Result<std::vector<KeptTrajectory>>> AsyncTrajectoryStore::trajectories() const {
  return ask<&Store::trajectories, &TrajectoryStore::trajectories>(store_);
}

Awaitable<Result<std::vector<StopRecord>>> AsyncStopStore::keep(
    std::vector<StopRecord> stops) const {
  return commit<&Store::stops, &StopStore::keep>(store_, "before_stop_commit", "after_stop_commit",
                                                 std::move(stops));
}

Awaitable<Result<bool>> AsyncStopStore::confirm(StopRecord stop, CellTime at) const {
  return commit<&Store::stops, &StopStore::confirm>(
      store_, "before_stop_confirm_commit", "after_stop_confirm_commit", std::move(stop), at);
}

Awaitable<Result<std::int64_t>> AsyncClosureStore::add_closure(
    ClosureRecord closure, std::optional<RepeatedLine> repeated) const {
  return ask<&Store::closures, &ClosureStore::add_closure>(store_, std::move(closure),
                                                           std::move(repeated));
}

Awaitable<Result<std::vector<ClosureRecord>>> AsyncClosureStore::closures(RunId run) const {
  return ask<&Store::closures, &ClosureStore::closures>(store_, run);
}

Awaitable<Result<std::vector<PointId>>> AsyncClosureStore::repeated_points(RunId run) const {
  return ask<&Store::closures, &ClosureStore::repeated_points>(store_, run);
}

Awaitable<Result<std::int64_t>> AsyncRestStore::begin_rest(RestRecord rest) const {
  return ask<&Store::rests, &RestStore::begin_rest>(store_, std::move(rest));
}

Awaitable<Result<void>> AsyncRestStore::end_rest(std::int64_t id, CellTime at,
                                                 std::string reason) const {
  return ask<&Store::rests, &RestStore::end_rest>(store_, id, at, std::move(reason));
}

Awaitable<Result<std::optional<RestRecord>>> AsyncRestStore::newest_rest() const {
  return ask<&Store::rests, &RestStore::newest_rest>(store_);
}

Awaitable<Result<void>> AsyncClockStore::add_clock(ClockRecord record) const {
  return ask<&Store::clocks, &ClockStore::add_clock>(store_, std::move(record));
}

Awaitable<Result<std::vector<ConfigurationStart>>> AsyncConfigurationStore::starts(
    int limit) const {
  return ask<&Store::configurations, &ConfigurationStore::starts>(store_, limit);
}

Awaitable<Result<ConfigurationStart>> AsyncConfigurationStore::accept(
    std::int64_t start, CellTime at, std::string who, std::string note,
    std::optional<RunId> continued) const {
  return commit<&Store::configurations, &ConfigurationStore::accept>(
      store_, "before_configuration_commit", "after_configuration_commit", start, at,
      std::move(who), std::move(note), continued);
}

Awaitable<Result<void>> AsyncConfigurationStore::continue_run(RunId run,
                                                              UsedConfiguration used) const {
  return ask<&Store::configurations, &ConfigurationStore::continue_run>(store_, run,
                                                                        std::move(used));
}

Awaitable<Result<AuditRecord>> AsyncAuditStore::add(AuditRecord act,
                                                    std::optional<EventRecord> event) const {
  return ask<&Store::audit, &AuditStore::add>(store_, std::move(act), std::move(event));
}

Awaitable<Result<std::vector<AuditRecord>>> AsyncAuditStore::acts(std::int64_t before_id,
                                                                  int limit) const {
  return ask<&Store::audit, &AuditStore::acts>(store_, before_id, limit);
}

Awaitable<Result<ChainHead>> AsyncAuditStore::head() const {
  return ask<&Store::audit, &AuditStore::head>(store_);
}

Awaitable<Result<QueueRecord>> AsyncQueueStore::queue(int history) const {
  return ask<&Store::queue, &QueueStore::queue>(store_, history);
}

Awaitable<Result<void>> AsyncQueueStore::change_queue(QueueChange change) const {
  return commit<&Store::queue, &QueueStore::change_queue>(store_, "before_queue_commit",
                                                          "after_queue_commit", std::move(change));
}

Awaitable<Result<RunRecord>> AsyncMetadataStore::tag(RunId run, RunMetadata set,
                                                     std::vector<std::string> removed) const {
  return ask<&Store::metadata, &MetadataStore::tag>(store_, run, std::move(set),
                                                    std::move(removed));
}

Awaitable<Result<std::vector<RunRecord>>> AsyncMetadataStore::find_runs(
    RunMetadata all_of, int limit, std::int64_t before_id) const {
  return ask<&Store::metadata, &MetadataStore::find_runs>(store_, std::move(all_of), limit,
                                                          before_id);
}

Awaitable<Result<IndentationRecord>> AsyncIndentationStore::add_indentation(
    IndentationRecord record) const {
  return ask<&Store::indentations, &IndentationStore::add_indentation>(store_, std::move(record));
}

Awaitable<Result<void>> AsyncIndentationStore::change_indentation(IndentationRecord record) const {
  return ask<&Store::indentations, &IndentationStore::change_indentation>(store_,
                                                                          std::move(record));
}

Awaitable<Result<IndentationRecord>> AsyncIndentationStore::indentation(IndentationId id) const {
  return ask<&Store::indentations, &IndentationStore::indentation>(store_, id);
}

Awaitable<Result<std::vector<IndentationRecord>>> AsyncIndentationStore::indentations(
    int limit) const {
  return ask<&Store::indentations, &IndentationStore::indentations>(store_, limit);
}

Awaitable<Result<PlanRecord>> AsyncPlanStore::add_plan(PlanRecord plan) const {
  return ask<&Store::plans, &PlanStore::add_plan>(store_, std::move(plan));
}

Awaitable<Result<PlanRecord>> AsyncPlanStore::plan(PlanId id) const {
  return ask<&Store::plans, &PlanStore::plan>(store_, id);
}

Awaitable<Result<std::vector<PlanRecord>>> AsyncPlanStore::plans() const {
  return ask<&Store::plans, &PlanStore::plans>(store_);
}

Awaitable<Result<void>> AsyncPlanStore::add_plan_promotion(PlanPromotionRecord promotion) const {
  return ask<&Store::plans, &PlanStore::add_plan_promotion>(store_, std::move(promotion));
}

Awaitable<Result<std::vector<PlanPromotionRecord>>> AsyncPlanStore::plan_promotions() const {
  return ask<&Store::plans, &PlanStore::plan_promotions>(store_);
}

}  // namespace driftwise::application
