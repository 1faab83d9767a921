#pragma once
// A Cell in memory: what clients of the API can be tested against without devices, clock or
// database.
//
// It keeps runs, events, models and promotions as a store would, refuses what a cell refuses
// (lease, unknown ids) and fails on request. Everything on the executor's thread, like the real
// one; tests go through on_executor().

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>

#include "server/application/plumbing/watch_list.h"
#include "server/application/ports/provenance.h"
#include "server/application/ports/studies.h"

namespace driftwise::tests {

namespace app = driftwise::application;

class FakeCell final : public app::Cell,
                       private app::Watching,
                       private app::Studies,
                       private app::Provenance {
 public:
  FakeCell();
  ~FakeCell() override;

  // Runs work on the cell's thread and waits for it.
  template <class Work>
  auto on_executor(Work work) {
    std::promise<decltype(work())> done;
    asio::post(context_, [&] {
      if constexpr (std::is_void_v<decltype(work())>) {
        work();
        done.set_value();
      } else {
        done.set_value(work());
      }
    });
    return done.get_future().get();
  }

  // --- what tests set and look at, on the executor's thread ---
  std::optional<Error> fail_next;  // the next call that can fail does, with this
  std::vector<std::string> calls;  // "move_to ada q=0.25"
  app::Caller last_caller;
  app::CreateRun last_create;
  app::HoldAnswer last_answer;
  app::FitRequest last_fit;
  app::MethodsRequest last_methods;
  app::SensorsRequest last_sensors;
  app::CellStatus the_status;
  std::map<std::int64_t, RunRecord> the_runs;
  bool aborts_later = false;  // the answer to an abort shows the run as it was
  std::vector<PointRecord> the_points;
  std::vector<AttemptRecord> the_attempts;
  std::vector<DatumRecord> the_datums;
  std::vector<EventRecord> the_events;
  std::vector<ModelRecord> the_models;
  std::vector<PromotionRecord> the_promotions;
  std::vector<calibration::OfferResult> the_offers;
  diagnosis::CheckReport the_check;
  app::FormulaCheck the_formula_check;
  app::ModelResiduals the_residuals;
  diagnosis::Verification the_verification;
  std::vector<ExclusionRecord> the_exclusions;  // of any run: rows as asked for
  std::vector<NoteRecord> the_notes;
  std::vector<app::DiagnosisView> the_diagnoses;  // newest last
  formats::DiscrepancyRows the_rows;
  std::vector<ImprovementRecord> the_improvements;
  app::DiagnosisRequest last_diagnosis;
  app::AcceptRequest last_accept;
  app::ImproveRequest last_improve;
  std::vector<ConfigurationStart> the_starts;  // newest first
  app::ConfigurationView the_configuration;
  app::RunGround the_run_ground;      // of any run
  app::ModelGround the_model_ground;  // of any model; its questions keep a promotion back
  std::vector<CorrectionRecord> the_corrections;
  app::ExtensionPreview the_preview;
  std::string last_request_id;
  bool last_without_excluded = false;
  std::vector<AlarmRecord> the_alarms;                     // by change
  std::vector<DiagnosisChange> the_diagnosis_changes;      // numbered from 1, and after them ...
  std::vector<ImprovementChange> the_improvement_changes;  // ... these
  std::vector<identification::Judgement> the_judgements;
  app::SensorChoice the_choice;
  std::shared_ptr<app::Study> last_study;  // the asker's
  bool studies_wait = false;               // until they are stopped
  std::vector<KeptTrajectory> the_trajectories;
  SeriesQuery last_series;
  SeriesAnswer the_series;
  app::PastTargetsQuery last_past;
  app::PastTargets the_past;
  std::string the_database = "aa11";
  int pages_read = 0;
  std::string the_csv = "time_s,q1_mm,x_mm\n0,0,0\n";
  std::atomic<int> watchers = 0;        // streams that watch now
  std::atomic<int> watchers_begun = 0;  // and those that ever did
  compensation::SnapshotBoard board;
  CellTime the_time{1'700'000'000'000'000'000};

  void publish_progress(const app::RunProgress& progress) { progress_.publish(progress); }
  void publish_reading(const Reading& reading) { readings_.publish(reading); }
  void publish_diagnosis(const app::DiagnosisProgress& progress) { diagnosing_.publish(progress); }
  void publish_improvement(const app::ImprovementProgress& progress) {
    improving_.publish(progress);
  }
  void publish_snapshot(compensation::Snapshot snapshot);
  EventId add_event(const std::string& what);
  ModelId add_model(const std::string& formula);  // q1 = 1e-6 + x, with plausible figures

  // --- Cell ---
  asio::any_io_executor executor() const override;
  asio::any_io_executor background() const override { return executor(); }
  CellTime now() const override { return the_time; }
  void start() override {}
  Awaitable<void> devices_looked_at() override { co_return; }
  Awaitable<void> shut_down() override { co_return; }
  app::CellStatus status() const override { return the_status; }
  const CellDescription& description() const override { return description_; }
  Result<app::Lease> take_lease(const app::Caller& caller, Nanoseconds duration,
                                const std::string& token) override;
  Result<void> give_up_lease(const app::Caller& caller, const std::string& token) override;
  Awaitable<Result<app::TrajectoryCheck>> check_trajectory(std::string text) override;
  Awaitable<Result<RunRecord>> create_run(app::Caller caller, app::CreateRun request) override;
  Awaitable<Result<RunRecord>> pause_run(app::Caller caller, RunId run) override;
  Awaitable<Result<RunRecord>> resume_run(app::Caller caller, RunId run,
                                          app::HoldAnswer answer) override;
  Awaitable<Result<RunRecord>> abort_run(app::Caller caller, RunId run, std::string why) override;
  Awaitable<Result<RunRecord>> confirm_force(app::Caller caller, RunId run,
                                             double force_n) override;
  Awaitable<Result<app::StopAnswer>> stop_all(app::Caller caller) override;
  app::StopAnswer stop_answer{true, "axis: no motion, in two successive answers", {}};
  Awaitable<Result<void>> home(app::Caller caller, std::string lease_token,
                               app::HoldAnswer answer) override;
  Awaitable<Result<void>> move_to(app::Caller caller, std::string lease_token,
                                  std::vector<double> q_mm, app::HoldAnswer answer) override;
  Awaitable<Result<void>> set_stabiliser(app::Caller caller, std::string lease_token,
                                         std::string device, double degc) override;
  Watch watch_progress(std::function<void(const app::RunProgress&)> on_change) override;
  Watch watch_events(std::function<void(const EventRecord&)> on_event) override;
  Watch watch_readings(std::function<void(const Reading&)> on_reading) override;
  Watch watch_snapshots(std::function<void()> on_rebuilt) override;
  Awaitable<Result<std::vector<RunRecord>>> runs(int limit, std::int64_t before_id) override;
  Awaitable<Result<RunRecord>> run(RunId run) override;
  Awaitable<Result<std::vector<PointRecord>>> points(RunId run, std::int64_t after_id,
                                                     int limit) override;
  Awaitable<Result<std::vector<AttemptRecord>>> attempts(RunId run) override;
  Awaitable<Result<std::vector<DatumRecord>>> data(RunId run) override;
  Awaitable<Result<std::vector<EventRecord>>> events(EventId after, int limit) override;
  Awaitable<Result<std::string>> export_dataset(std::vector<RunId> runs,
                                                bool without_excluded) override;
  Awaitable<Result<RunRecord>> import_dataset(app::Caller caller, std::string name, std::string csv,
                                              std::string request_id) override;
  Awaitable<Result<app::ExclusionState>> exclude_rows(app::Caller caller,
                                                      ExclusionRecord wanted) override;
  Awaitable<Result<app::ExclusionState>> exclusions(RunId run) override;
  Awaitable<Result<NoteRecord>> add_note(app::Caller caller, NoteSubject on,
                                         std::string text) override;
  Awaitable<Result<std::vector<NoteRecord>>> notes(NoteSubject on) override;
  Awaitable<Result<ModelRecord>> fit(app::Caller caller, app::FitRequest request) override;
  Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(
      app::FitRequest request) override;
  Awaitable<Result<app::FormulaCheck>> check_formula(app::FitRequest request) override;
  Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId> runs,
                                                         std::optional<ModelId> range) override;
  Awaitable<Result<app::ModelResiduals>> residuals(ModelId model, std::vector<RunId> runs,
                                                   std::string csv) override;
  Awaitable<Result<app::ModelCheck>> check_model(std::optional<ModelId> model,
                                                 std::vector<RunId> runs) override;
  Awaitable<Result<std::vector<ModelRecord>>> models() override;
  Awaitable<Result<ModelRecord>> model(ModelId id) override;
  Awaitable<Result<ModelRecord>> promote(app::Caller caller, ModelId id, bool confirmed) override;
  Awaitable<Result<std::optional<ModelRecord>>> roll_back(app::Caller caller) override;
  Awaitable<Result<std::vector<PromotionRecord>>> promotions() override;
  app::Watching& watching() override { return *this; }
  app::Studies& studies() override { return *this; }
  app::Provenance& provenance() override { return *this; }
  Awaitable<Result<app::DiagnosisView>> create_diagnosis(app::Caller caller,
                                                         app::DiagnosisRequest request) override;
  Awaitable<Result<app::DiagnosisView>> diagnosis(DiagnosisId id) override;
  Awaitable<Result<formats::DiscrepancyRows>> diagnosis_rows(DiagnosisId id) override;
  Awaitable<Result<std::vector<app::DiagnosisView>>> diagnoses() override;
  Awaitable<Result<app::DiagnosisView>> cancel_diagnosis(app::Caller caller,
                                                         DiagnosisId id) override;
  Awaitable<Result<ExtensionRecord>> accept_extension(app::Caller caller,
                                                      app::AcceptRequest request) override;
  Awaitable<Result<ExtensionRecord>> undo_extension(app::Caller caller, DiagnosisId id) override;
  Awaitable<Result<ImprovementRecord>> create_improvement(app::Caller caller,
                                                          app::ImproveRequest request) override;
  Awaitable<Result<ImprovementRecord>> improvement(ImprovementId id) override;
  Awaitable<Result<std::vector<ImprovementRecord>>> improvements() override;
  Awaitable<Result<ImprovementRecord>> cancel_improvement(app::Caller caller,
                                                          ImprovementId id) override;
  Watch watch_diagnoses(std::function<void(const app::DiagnosisProgress&)> on_change) override;
  Watch watch_improvements(std::function<void(const app::ImprovementProgress&)> on_change) override;
  const compensation::SnapshotBoard& snapshots() const override { return board; }

 private:
  Awaitable<Result<app::RecordHead>> record_head() override;
  Awaitable<Result<RecordPage>> records(RecordCursor after, RecordCursor until, int limit) override;
  std::shared_ptr<void> watch_records(std::function<void()> on_news) override;
  Awaitable<Result<std::vector<AlarmRecord>>> alarms(bool with_history, int limit) override;
  Awaitable<Result<AlarmRecord>> acknowledge_alarm(app::Caller caller, AlarmId id) override;
  Awaitable<Result<SeriesAnswer>> series(SeriesQuery query) override;
  Awaitable<Result<app::PastTargets>> past_targets(app::PastTargetsQuery query) override;
  Awaitable<Result<KeptTrajectory>> keep_trajectory(app::Caller caller, std::string name,
                                                    std::string text) override;
  Awaitable<Result<KeptTrajectory>> trajectory(TrajectoryId id) override;
  Awaitable<Result<std::vector<KeptTrajectory>>> trajectories() override;
  Awaitable<Result<std::vector<identification::Judgement>>> compare_methods(
      app::MethodsRequest request, std::shared_ptr<app::Study> study) override;
  Awaitable<Result<app::SensorChoice>> study_sensors(app::SensorsRequest request,
                                                     std::shared_ptr<app::Study> study) override;
  Awaitable<Result<std::vector<ConfigurationStart>>> configurations(int limit) override;
  Awaitable<Result<app::ConfigurationView>> configuration(std::string hash,
                                                          std::string compare_hash) override;
  Awaitable<Result<ConfigurationStart>> accept_configuration(app::Caller caller, std::string hash,
                                                             std::string note) override;
  Awaitable<Result<std::vector<app::RunGround>>> grounds_of_runs(std::vector<RunId> runs) override;
  Awaitable<Result<app::ModelGround>> ground_of_model(ModelId id) override;
  Awaitable<Result<std::vector<CorrectionRecord>>> corrections() override;
  Awaitable<Result<app::ExtensionPreview>> preview_extension(app::AcceptRequest request) override;
  Awaitable<bool> studied(std::shared_ptr<app::Study> study);  // false: it was stopped
  std::optional<Error> take_failure();
  Result<RunRecord> find_run(RunId run) const;
  Result<app::DiagnosisView*> find_diagnosis(DiagnosisId id);
  Result<void> check_lease(const std::string& token) const;
  Result<RunRecord> change_state(const app::Caller& caller, RunId run, RunState state,
                                 std::string reason);
  Watch counted(std::shared_ptr<void> watch);

  asio::io_context context_{1};
  CellDescription description_;
  std::optional<app::Lease> lease_;
  app::WatchList<app::RunProgress> progress_;
  app::WatchList<EventRecord> event_watch_;
  app::WatchList<Reading> readings_;
  app::WatchList<> snapshots_;
  app::WatchList<app::DiagnosisProgress> diagnosing_;
  app::WatchList<app::ImprovementProgress> improving_;
  std::thread thread_;
};

}  // namespace driftwise::tests
