#pragma once
// The Cell: puts the parts together and answers clients. What is more than a few lines lives in a
// part of its own.

#include <boost/asio/thread_pool.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/alarms/alarm_book.h"
#include "server/application/alarms/alarm_conditions.h"
#include "server/application/alarms/incidents.h"
#include "server/application/analyses/study_desk.h"
#include "server/application/diagnoses/diagnosis_desk.h"
#include "server/application/improvement/improver.h"
#include "server/application/motion/lease_book.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/motion/stop_events.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/pause_meter.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/cell.h"
#include "server/application/ports/provenance.h"
#include "server/application/ports/studies.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/recording/device_bench.h"
#include "server/application/recording/device_keeper.h"
#include "server/application/recording/doubts.h"
#include "server/application/recording/recorder.h"
#include "server/application/runs/run_engine.h"
#include "server/application/serving/serving.h"
#include "server/application/upkeep/database_upkeep.h"
#include "server/application/upkeep/wall_clock_watch.h"
#include "server/core/ports/async_mutex.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

// One thread of its own, or an executor that was handed in.
class Thread {
 public:
  explicit Thread(asio::any_io_executor given) : given_(std::move(given)) {
    if (!given_) own_.emplace(1);
  }
  asio::any_io_executor executor() const {
    return own_ ? asio::any_io_executor(own_->get_executor()) : given_;
  }
  void join() {
    if (own_) own_->join();
  }

 private:
  asio::any_io_executor given_;
  mutable std::optional<asio::thread_pool> own_;  // its executor is no part of its state
};

class CellApplication final : public Cell, private Watching, private Studies, private Provenance {
 public:
  CellApplication(asio::any_io_executor executor, Parts parts, std::unique_ptr<Store> writing,
                  std::unique_ptr<Store> reading, std::unique_ptr<Store> checking,
                  ConfigurationBook configuration);
  ~CellApplication() override;

  void know_clock(ClockStart start) { clock_start_ = std::move(start); }  // before start()
  // Stops that no controller had confirmed when the daemon ended. Before start().
  void restore_stops(std::vector<StopRecord> pending) { stops_.restore(std::move(pending)); }
  // How many diagnoses and improvements were under way when the daemon ended.
  void tell_of_unfinished(std::int64_t count);

  asio::any_io_executor executor() const override { return executor_; }
  asio::any_io_executor background() const override { return text_thread_.executor(); }
  CellTime now() const override { return clock_->now().utc; }
  UtcTime utc(CellTime instant) const override { return clock_->utc(instant); }
  CellTime cell_time(UtcTime utc) const override { return clock_->cell_time(utc); }
  void start() override;
  Awaitable<void> devices_looked_at() override { return keeper_.looked(); }
  Awaitable<void> shut_down() override;
  CellStatus status() const override;
  const CellDescription& description() const override { return description_; }

  Result<Lease> take_lease(const Caller& caller, Nanoseconds duration,
                           const std::string& token) override;
  Result<void> give_up_lease(const Caller& caller, const std::string& token) override;

  Awaitable<Result<TrajectoryCheck>> check_trajectory(std::string text) override;
  Awaitable<Result<RunRecord>> create_run(Caller caller, CreateRun request) override;
  Awaitable<Result<RunRecord>> pause_run(Caller caller, RunId run) override;
  Awaitable<Result<RunRecord>> resume_run(Caller caller, RunId run, HoldAnswer answer) override;
  Awaitable<Result<RunRecord>> abort_run(Caller caller, RunId run, std::string why) override;
  Awaitable<Result<RunRecord>> confirm_force(Caller caller, RunId run, double force_n) override;
  Awaitable<Result<StopAnswer>> stop_all(Caller caller) override;
  Awaitable<Result<void>> home(Caller caller, std::string lease_token, HoldAnswer answer) override;
  Awaitable<Result<void>> move_to(Caller caller, std::string lease_token, std::vector<double> q_mm,
                                  HoldAnswer answer) override;
  Awaitable<Result<void>> set_stabiliser(Caller caller, std::string lease_token, std::string device,
                                         double degc) override;

  Watch watch_progress(std::function<void(const RunProgress&)> on_change) override;
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
  Awaitable<Result<RunRecord>> import_dataset(Caller caller, std::string name, std::string csv,
                                              std::string request_id) override;
  Awaitable<Result<ExclusionState>> exclude_rows(Caller caller, ExclusionRecord wanted) override;
  Awaitable<Result<ExclusionState>> exclusions(RunId run) override;
  Awaitable<Result<NoteRecord>> add_note(Caller caller, NoteSubject on, std::string text) override;
  Awaitable<Result<std::vector<NoteRecord>>> notes(NoteSubject on) override;

  Awaitable<Result<ModelRecord>> fit(Caller caller, FitRequest request) override;
  Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(
      FitRequest request) override;
  Awaitable<Result<FormulaCheck>> check_formula(FitRequest request) override;
  Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId> runs,
                                                         std::optional<ModelId> range) override;
  Awaitable<Result<ModelResiduals>> residuals(ModelId model, std::vector<RunId> runs,
                                              std::string csv) override;
  Awaitable<Result<ModelCheck>> check_model(std::optional<ModelId> id,
                                            std::vector<RunId> runs) override;
  Awaitable<Result<std::vector<ModelRecord>>> models() override;
  Awaitable<Result<ModelRecord>> model(ModelId id) override;
  Awaitable<Result<ModelRecord>> promote(Caller caller, ModelId id, bool confirmed) override;
  Awaitable<Result<std::optional<ModelRecord>>> roll_back(Caller caller) override;
  Awaitable<Result<std::vector<PromotionRecord>>> promotions() override;
  Watching& watching() override { return *this; }
  Studies& studies() override { return *this; }
  Provenance& provenance() override { return *this; }
  Awaitable<Result<DiagnosisView>> create_diagnosis(Caller caller,
                                                    DiagnosisRequest request) override;
  Awaitable<Result<DiagnosisView>> diagnosis(DiagnosisId id) override;
  Awaitable<Result<formats::DiscrepancyRows>> diagnosis_rows(DiagnosisId id) override;
  Awaitable<Result<std::vector<DiagnosisView>>> diagnoses() override;
  Awaitable<Result<DiagnosisView>> cancel_diagnosis(Caller caller, DiagnosisId id) override;
  Awaitable<Result<ExtensionRecord>> accept_extension(Caller caller,
                                                      AcceptRequest request) override;
  Awaitable<Result<ExtensionRecord>> undo_extension(Caller caller, DiagnosisId id) override;
  Awaitable<Result<ImprovementRecord>> create_improvement(Caller caller,
                                                          ImproveRequest request) override;
  Awaitable<Result<ImprovementRecord>> improvement(ImprovementId id) override;
  Awaitable<Result<std::vector<ImprovementRecord>>> improvements() override;
  Awaitable<Result<ImprovementRecord>> cancel_improvement(Caller caller, ImprovementId id) override;
  Watch watch_diagnoses(std::function<void(const DiagnosisProgress&)> on_change) override;
  Watch watch_improvements(std::function<void(const ImprovementProgress&)> on_change) override;
  const compensation::SnapshotBoard& snapshots() const override { return serving_.board(); }

 private:
  Awaitable<Result<RecordHead>> record_head() override;
  Awaitable<Result<RecordPage>> records(RecordCursor after, RecordCursor until, int limit) override;
  std::shared_ptr<void> watch_records(std::function<void()> on_news) override;
  Awaitable<Result<std::vector<AlarmRecord>>> alarms(bool with_history, int limit) override;
  Awaitable<Result<AlarmRecord>> acknowledge_alarm(Caller caller, AlarmId id) override;
  Awaitable<Result<SeriesAnswer>> series(SeriesQuery query) override;
  Awaitable<Result<PastTargets>> past_targets(PastTargetsQuery query) override;
  Awaitable<Result<KeptTrajectory>> keep_trajectory(Caller caller, std::string name,
                                                    std::string text) override;
  Awaitable<Result<KeptTrajectory>> trajectory(TrajectoryId id) override;
  Awaitable<Result<std::vector<KeptTrajectory>>> trajectories() override;
  Awaitable<Result<std::vector<identification::Judgement>>> compare_methods(
      MethodsRequest request, std::shared_ptr<Study> study) override;
  Awaitable<Result<SensorChoice>> study_sensors(SensorsRequest request,
                                                std::shared_ptr<Study> study) override;
  Awaitable<Result<std::vector<ConfigurationStart>>> configurations(int limit) override;
  Awaitable<Result<ConfigurationView>> configuration(std::string hash,
                                                     std::string compare_hash) override;
  Awaitable<Result<ConfigurationStart>> accept_configuration(Caller caller, std::string hash,
                                                             std::string note) override;
  Awaitable<Result<std::vector<RunGround>>> grounds_of_runs(std::vector<RunId> runs) override;
  Awaitable<Result<ModelGround>> ground_of_model(ModelId id) override;
  Awaitable<Result<std::vector<CorrectionRecord>>> corrections() override;
  Awaitable<Result<ExtensionPreview>> preview_extension(AcceptRequest request) override;
  Awaitable<Result<std::vector<LengthChange>>> changes_in_all_runs(
      correction::DataAmendment amendment, std::vector<RunId> diagnosed);
  Awaitable<Result<std::optional<ModelRecord>>> served_before();  // what rollback would serve
  void tell_serving(const Caller& caller, std::optional<ModelRecord> next,
                    const std::string& action);  // event, and whether it still holds
  std::string waits_for_configuration(const RunRecord& run) const;
  Awaitable<void> look_for_alarms();
  std::vector<AlarmCondition> alarms_now() const;
  void note_for_alarms(const RunProgress& progress);
  void note_clock_jumps();
  // False also where no pose is measured, or none counts from a datum.
  Awaitable<bool> axes_measured_at(std::vector<double> q_mm);
  void axes_moved_uncommanded(const std::string& what);
  Awaitable<void> halt_axes();

  class ByHand;
  Awaitable<void> start_up();
  Awaitable<Result<void>> restore_datum();
  Awaitable<Result<void>> restore_force();
  Awaitable<Result<void>> restore_model();
  Awaitable<Result<void>> go_on_with_run();
  Awaitable<Result<RunBefore>> what_was_before(const RunRecord& run);
  Awaitable<Result<void>> follow_for(const RunPlan& plan);
  Awaitable<Result<RunRecord>> start_run(Caller caller, CreateRun request, RunPlan plan,
                                         Trajectory trajectory);
  Awaitable<Result<TrajectoryCheck>> checked(std::string name, std::string text);
  Result<RunControl*> control_of(RunId run, const char* verb);
  Awaitable<Result<RunRecord>> steer(Caller caller, RunId run, const char* verb, std::string detail,
                                     std::function<void(RunControl&)> act);
  Result<void> may_move(const std::string& lease_token) const;
  // The same for a movement by hand, which a run that stands allows to whom it may end.
  Result<void> may_move_by_hand(const Caller& caller, const std::string& lease_token,
                                const HoldAnswer& answer) const;
  std::optional<double> force_now() const;  // on the end-effector, as far as it is known
  Awaitable<Result<DatumRecord>> new_datum_by_hand(RunScope& scope, std::string reason);
  void take_datum(const DatumRecord& datum);  // poses and targets count from it now
  Awaitable<Result<void>> put_in_service(Caller caller, std::optional<ModelRecord> next,
                                         std::string action);
  std::vector<std::string> attention() const;
  Awaitable<Result<Dataset>> fit_data(FitRequest request);
  Awaitable<Result<void>> resolve_baseline(DiagnosisRequest& request);
  void check_after(const RunProgress& progress);
  Awaitable<void> check_serving_model(std::optional<RunId> after);

  asio::any_io_executor executor_;
  CellDescription description_;
  ConfigurationBook configuration_;
  std::unique_ptr<Clock> clock_;
  std::string version_, web_address_, boot_id_;
  Thread storage_thread_, query_thread_, worker_thread_, diagnosis_thread_, text_thread_,
      upkeep_thread_;
  StoreWriter writer_;
  StoreReader reader_, checker_;
  EventLog events_;
  Doubts doubts_;
  DeviceBench bench_;
  LagMeter lag_;
  PauseMeter pauses_;
  TaskGroup tasks_;
  StopEvents stop_events_;
  StopDesk stops_;
  DeviceKeeper keeper_;
  PoseStage pose_;
  Loading loading_;
  Recorder recorder_;
  Workbench workbench_;
  Serving serving_;
  RunEngine engine_;
  LeaseBook leases_;
  AlarmBook alarm_book_;
  Incidents incidents_;
  QualityTrend quality_;
  std::optional<RunId> last_failed_;                 // of which an alarm was made
  std::map<std::string, std::int64_t> clock_jumps_;  // by device, of which an event was made
  Signal alarms_end_;
  bool ending_ = false, measure_pauses_ = false;
  DiagnosisDesk desk_;
  Improver improver_;
  StudyDesk study_desk_;
  WallClockWatch wall_clock_;
  ClockStart clock_start_;
  DatabaseUpkeep upkeep_;
  AsyncMutex beginning_;  // one at a time decides whether a run or a movement may begin
  std::optional<RunControl> by_hand_;  // set while somebody homes or moves without a run
  std::string by_hand_waits_;          // what such a movement waits for: a sentence
  std::string motion_trouble_;         // motion without a command, until a datum is opened
  std::string datum_trouble_;          // the axes were homed, and no datum is open since
  std::string check_trouble_;          // "recalibrate now: ...", of the model that serves
  std::optional<RunId> checked_;       // the last run that was looked at when it ended
  Watch run_watch_;
};

}  // namespace driftwise::application
