#pragma once
// The parts of a cell and how they hold each other. Members are made in this order and destroyed in
// reverse.

#include <boost/asio/thread_pool.hpp>
#include <optional>

#include "server/application/access/access_desk.h"
#include "server/application/alarms/alarm_book.h"
#include "server/application/alarms/alarms_service.h"
#include "server/application/analyses/studies_service.h"
#include "server/application/annotations/annotations_service.h"
#include "server/application/cell/cell.h"
#include "server/application/checks/model_checks_service.h"
#include "server/application/commissioning/commissioning_service.h"
#include "server/application/configuration/configurations_service.h"
#include "server/application/datasets/datasets_service.h"
#include "server/application/diagnoses/diagnoses_service.h"
#include "server/application/diagnoses/extensions_service.h"
#include "server/application/holds/hold_desk.h"
#include "server/application/improvement/improvements_service.h"
#include "server/application/indentations/indentations_service.h"
#include "server/application/look_back/look_back_service.h"
#include "server/application/manual/jog_desk.h"
#include "server/application/manual/manual_control_service.h"
#include "server/application/models/models_service.h"
#include "server/application/models/promotions_service.h"
#include "server/application/notify/notify_desk.h"
#include "server/application/plans/plans_service.h"
#include "server/application/plumbing/pause_meter.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/host.h"
#include "server/application/provenance/provenance_service.h"
#include "server/application/queue/queue_service.h"
#include "server/application/recording/device_keeper.h"
#include "server/application/report/reports_service.h"
#include "server/application/runs/runs_service.h"
#include "server/application/status/overview_service.h"
#include "server/application/support/support_service.h"
#include "server/application/trajectories/duration_book.h"
#include "server/application/trajectories/trajectories_service.h"
#include "server/application/upkeep/wall_clock_watch.h"
#include "server/application/watching/feeds_service.h"

namespace driftwise::application {

// One thread of its own (or several, where that is said), or an executor that was handed in.
class Thread {
 public:
  explicit Thread(asio::any_io_executor given, std::size_t threads = 1) : given_(std::move(given)) {
    if (!given_) own_.emplace(threads);
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

class CellHost final : public Host {
 public:
  CellHost(asio::any_io_executor executor, asio::any_io_executor background, const Clock& clock)
      : executor_(std::move(executor)), background_(std::move(background)), clock_(clock) {}
  asio::any_io_executor executor() const override { return executor_; }
  asio::any_io_executor background() const override { return background_; }
  CellTime now() const override { return clock_.now().utc; }
  UtcTime utc(CellTime instant) const override { return clock_.utc(instant); }
  CellTime cell_time(UtcTime utc) const override { return clock_.cell_time(utc); }

 private:
  asio::any_io_executor executor_, background_;
  const Clock& clock_;
};

// Stores of a cell, opened on one file, and what they said when it was opened.
struct OpenedRecord {
  std::unique_ptr<Store> writing, reading, checking;
  ConfigurationBook configuration;
  ClockStart clock_start;
  std::vector<StopRecord> stops;  // that no controller had confirmed when the daemon ended
  QueueRecord queue;
  std::int64_t unfinished_jobs = 0;       // diagnoses and improvements under way then
  std::string interrupted_improvement{};  // a sentence for its event; empty: there was none
};

class Composition {
 public:
  Composition(asio::any_io_executor executor, Cell::Parts given, OpenedRecord opened);
  ~Composition();

  void start();
  // Resumes when the promoted model or plan serves, or is refused with its reason.
  Awaitable<void> served_again();
  Awaitable<void> come_to_rest();
  Awaitable<void> shut_down();
  Services services();

  asio::any_io_executor executor;
  CellDescription description;
  ConfigurationBook configuration;
  std::unique_ptr<Clock> clock;
  std::string version, boot_id;
  Thread storage_thread, query_thread, worker_thread, diagnosis_thread, text_thread, upkeep_thread,
      notify_threads;
  std::unique_ptr<Notifier> notifier;
  CellHost host;
  StoreWriter writer;
  StoreReader reader, checker;
  EventLog events;
  Doubts doubts;
  DeviceBench bench;
  LagMeter lag;
  PauseMeter pauses;
  TaskGroup tasks;
  StopEvents stop_events;
  StopDesk stops;
  DeviceKeeper keeper;
  PoseStage pose;
  Loading loading;
  Recorder recorder;
  DurationBook durations;
  Workbench workbench;
  Serving serving;
  JointServing joint_serving;
  RunEngine engine;
  LeaseBook leases;
  RightToMove right;
  AlarmBook alarm_book;
  NotifyDesk notify;
  DiagnosisDesk diagnosis_desk;
  StudyDesk study_desk;
  WallClockWatch wall_clock;
  ClockStart clock_start;
  DatabaseUpkeep upkeep;
  AccessDesk access;
  HoldDesk holds;

  // Services.
  TrajectoriesService trajectories;
  DatasetsService datasets;
  AnnotationsService annotations;
  ModelsService models;
  ProvenanceService provenance;
  ModelChecksService checks;
  PromotionsService promotions;
  RunsService runs;
  ManualControlService manual;
  ConfigurationsService configurations;
  DiagnosesService diagnoses;
  ExtensionsService extensions;
  Improver improver;
  ImprovementsService improvements;
  StudiesService studies;
  OverviewService overview;
  AlarmsService alarms;
  FeedsService feeds;
  ReportsService reports;
  QueueDesk queue_desk;
  QueueService queue;
  PlansService plans;
  JogDesk jogs;
  RestDesk rests;
  CommissioningService commissioning;
  LookBackService look_back;
  IndentationsService indentations;
  SupportService support;

 private:
  Awaitable<void> start_up();
  Awaitable<std::string> rest_axes();  // why they are not known to rest; empty: they rest
  Awaitable<Result<void>> restore_datum();
  Awaitable<Result<void>> restore_force();
  Awaitable<Result<void>> restore_model();

  bool measure_pauses_ = false;
  bool served_again_ = false, comes_to_rest_ = false;
  Signal looked_for_what_serves_;
  std::shared_ptr<void> run_watch_;
};

}  // namespace driftwise::application
