#include "server/application/cell/cell_application.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/application/plumbing/run_on.h"
#include "server/application/runs/run_state_store.h"
#include "server/core/ports/spawn.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::application {

namespace {

StoreReader::Open reading_anew(const OpenStore& open_store, const std::string& path) {
  return [open_store, path] { return open_store(path, true); };
}

}  // namespace

Result<std::unique_ptr<Cell>> Cell::open(asio::any_io_executor executor, Parts parts) {
  DRIFTWISE_TRY(auto writing, parts.open_store(parts.description.database, false));
  DRIFTWISE_TRY(auto reading, parts.open_store(parts.description.database, true));
  DRIFTWISE_TRY(auto checking, parts.open_store(parts.description.database, true));
  DRIFTWISE_TRY(auto clocks, writing->clocks().clocks());
  DRIFTWISE_TRY(const auto newest, writing->clocks().newest_instant());
  auto clock_start = begin_cell_time(*parts.clock, std::move(clocks), newest);
  DRIFTWISE_RETURN_IF_ERROR(writing->clocks().add_clock(clock_start.records.back()));
  // Before anybody can begin a new one.
  DRIFTWISE_TRY(const auto unfinished,
                writing->diagnoses().fail_unfinished("the daemon ended while it ran",
                                                     parts.clock->now().utc));
  DRIFTWISE_TRY(auto stops, writing->stops().pending());
  DRIFTWISE_TRY(auto configuration, ConfigurationBook::open(*writing, parts.description,
                                                            parts.version, parts.clock->now()));
  auto cell = std::make_unique<CellApplication>(executor, std::move(parts), std::move(writing),
                                                std::move(reading), std::move(checking),
                                                std::move(configuration));
  cell->know_clock(std::move(clock_start));
  cell->restore_stops(std::move(stops));
  cell->tell_of_unfinished(unfinished);
  return cell;
}

namespace {

// Each controller confirms a stop for itself.
std::vector<StopDesk::Controller> controllers_of(DeviceBench& bench) {
  std::vector<StopDesk::Controller> controllers;
  for (const auto device : bench.with_role(DeviceRole::motion))
    controllers.push_back({bench.description(device).id,
                           [&bench, device] { return bench.stop(device); },
                           [&bench, device] { return bench.motion_state(device); }});
  return controllers;
}

}  // namespace

CellApplication::CellApplication(asio::any_io_executor executor, Parts parts,
                                 std::unique_ptr<Store> writing, std::unique_ptr<Store> reading,
                                 std::unique_ptr<Store> checking, ConfigurationBook configuration)
    : executor_(executor),
      description_(std::move(parts.description)),
      configuration_(std::move(configuration)),
      clock_(std::move(parts.clock)),
      version_(std::move(parts.version)),
      web_address_(std::move(parts.web_address)),
      boot_id_(std::move(parts.boot_id)),
      storage_thread_(parts.storage_thread),
      query_thread_(parts.query_thread),
      worker_thread_(parts.worker_thread),
      diagnosis_thread_(parts.diagnosis_thread),
      text_thread_(parts.text_thread),
      upkeep_thread_(parts.upkeep_thread),
      writer_(storage_thread_.executor(), std::move(writing)),
      reader_(executor, query_thread_.executor(), std::move(reading),
              reading_anew(parts.open_store, description_.database)),
      checker_(executor, upkeep_thread_.executor(), std::move(checking),
               reading_anew(parts.open_store, description_.database)),
      events_(executor, *clock_, writer_),
      doubts_(description_, *clock_, writer_, events_, [this] { alarms_end_.raise(); }),
      bench_(executor, std::move(parts.devices), doubts_,
             [this](const DeviceDescription& device, const Error* error) {
               if (error)
                 events_.record_own("device.lost", error->message);
               else
                 events_.record_own("device.back", fmt::format("{} at {} answers again", device.id,
                                                               device.address));
             }),
      lag_(*clock_),
      pauses_(executor),
      tasks_(executor),
      stop_events_(executor, *clock_, events_, tasks_),
      stops_(executor, *clock_, writer_, events_, tasks_, controllers_of(bench_)),
      keeper_(executor, *clock_, bench_, tasks_, [this] { return engine_.busy() || by_hand_; }),
      pose_(description_),
      recorder_(executor, *clock_, bench_, writer_, events_, lag_, pose_, tasks_),
      workbench_{description_, *clock_, bench_,   recorder_, writer_, events_,
                 lag_,         pose_,   loading_, stops_,    doubts_, boot_id_},
      serving_(executor, description_, configuration_, *clock_, recorder_, reader_, events_,
               tasks_),
      engine_(
          executor, workbench_,
          {[this](const ActiveRun& run, const TrajectoryPoint& row) -> Result<std::vector<double>> {
             if (!run.plan.compensate) return row.target_mm;
             TrajectoryPoint wanted = row;
             if (!wanted.force_n) wanted.force_n = loading_.known_n();
             return serving_.targets(run.trajectory.coordinates, wanted, run.plan.compensate_with);
           },
           [this](const DatumRecord& datum) { take_datum(datum); },
           [this](AlarmCondition condition) {
             spawn(executor_, alarm_book_.note(std::move(condition)));
           }},
          tasks_),
      leases_([this](CellTime instant) { return clock_->utc(instant); }),
      alarm_book_(*clock_, writer_),
      alarms_end_(executor),
      measure_pauses_(parts.measure_pauses),
      desk_(executor, diagnosis_thread_.executor(), *clock_, writer_, events_, tasks_,
            std::move(parts.diagnose)),
      improver_(executor, *this, *clock_, writer_, events_, tasks_),
      study_desk_(executor, diagnosis_thread_.executor(), tasks_),
      wall_clock_(executor, *clock_, writer_, events_, tasks_,
                  [this](AlarmCondition condition) {
                    spawn(executor_, alarm_book_.note(std::move(condition)));
                  }),
      upkeep_(executor, *clock_, description_.database, writer_, {&reader_}, &checker_, events_,
              tasks_, [this] { return engine_.busy() || by_hand_.has_value(); }),
      beginning_(executor) {
  bench_.allow_motion_if([this]() -> Result<void> {
    const auto allowed = stops_.check();
    if (allowed) return {};
    return fail(ErrorCode::aborted, allowed.error().reason, allowed.error().message);
  });
  bench_.watch_motion(
      MotionWatch::kPerInPosition * description_.run.in_position_nm,
      [this](std::vector<double> q_mm) { return axes_measured_at(std::move(q_mm)); },
      [this](const std::string& what) { axes_moved_uncommanded(what); });
}

CellApplication::~CellApplication() {
  // Nothing of ours may run on a thread of its own while members go.
  storage_thread_.join();
  query_thread_.join();
  worker_thread_.join();
  diagnosis_thread_.join();
  text_thread_.join();
  upkeep_thread_.join();
}

void CellApplication::start() {
  if (measure_pauses_) pauses_.start();
  wall_clock_.start(std::move(clock_start_));
  stops_.start();  // a pending stop is the first thing that a controller hears
  keeper_.start();
  recorder_.start();
  serving_.start();
  upkeep_.start();
  run_watch_ = engine_.watchers().add([this](const RunProgress& run) {
    check_after(run);
    note_for_alarms(run);
  });
  tasks_.spawn(look_for_alarms());
  tasks_.spawn(start_up());
}

Awaitable<void> CellApplication::start_up() {
  // Whoever wants to move meanwhile waits for his turn: a run may have to be gone on with first.
  const auto lock = co_await beginning_.lock();
  events_.record_own("daemon.started",
                     fmt::format("driftwised {} on cell '{}'", version_, description_.name));
  events_.record_own(
      configuration_.changes().empty() ? "configuration.in_force" : "configuration.changed",
      configuration_.event());
  const auto tell = [this](const char* what, const Result<void>& result) {
    if (!result)
      events_.record_own("daemon.trouble", fmt::format("{}: {}", what, result.error().message));
  };
  tell("finding the force that acts", co_await restore_force());
  tell("finding the present datum", co_await restore_datum());
  tell("serving the promoted model", co_await restore_model());
  tell("going on with the run", co_await go_on_with_run());
}

Awaitable<Result<void>> CellApplication::restore_datum() {
  DRIFTWISE_CO_TRY(auto datum, co_await reader_.runs().newest_datum());
  if (datum) take_datum(*datum);
  co_return Result<void>{};
}

// What a person said last; an actuator is asked when a run needs it.
Awaitable<Result<void>> CellApplication::restore_force() {
  constexpr int kMost = 100'000;  // weights are changed by hand
  const auto force = description_.force_channel();
  if (!force || description_.load_actuator()) co_return Result<void>{};
  const auto now = clock_->now().utc;
  DRIFTWISE_CO_TRY(const auto said,
                   co_await reader_.readings().readings(kOperatorDevice, CellTime{0}, now, kMost));
  if (said.empty()) co_return Result<void>{};
  recorder_.observe(JudgedReading{said.back(), {}});
  if (const double* force_n = said.back().find(force->name())) loading_.know(*force_n);
  co_return Result<void>{};
}

Awaitable<Result<void>> CellApplication::restore_model() {
  DRIFTWISE_CO_TRY(auto history, co_await promotions());
  if (history.empty() || !history.back().model) co_return Result<void>{};
  auto record = co_await model(*history.back().model);
  if (!record) {
    // Not another model in its place: targets are refused until a person promotes one.
    serving_.refuse(*history.back().model, record.error());
    co_return tl::unexpected(record.error());
  }
  if (auto ok = co_await serving_.serve(std::move(*record)); !ok) co_return ok;
  tasks_.spawn(check_serving_model(std::nullopt));
  co_return Result<void>{};
}

Awaitable<Result<void>> CellApplication::go_on_with_run() {
  DRIFTWISE_CO_TRY(
      auto unfinished, co_await reader_.call([](Store& store) -> Result<std::optional<RunRecord>> {
        auto run = store.runs().unfinished_run();
        if (!run || *run) return run;
        DRIFTWISE_TRY(auto newest, store.runs().runs(1, 0));  // created, and killed before it began
        if (!newest.empty() && newest.front().state == RunState::queued) return newest.front();
        return std::nullopt;
      }));
  if (!unfinished) co_return Result<void>{};
  auto record = std::move(*unfinished);
  DRIFTWISE_CO_TRY(auto trajectory,
                   co_await run_on(background(), formats::read_trajectory_csv,
                                   record.trajectory_text, record.trajectory_name));
  DRIFTWISE_CO_TRY(auto plan, read_run_plan(record.rules_json));
  if (auto ok = co_await follow_for(plan); !ok) co_return ok;
  std::optional<RunBefore> before;
  if (record.state != RunState::queued) {
    DRIFTWISE_CO_TRY(auto found, co_await what_was_before(record));
    before = std::move(found);
  }
  if (const auto stops = stops_.records(); !stops.empty()) {
    record.state = RunState::paused;
    record.reason = stops.front().cause;
  }
  // Measured on under another cell file only when a person has seen the difference.
  auto question = waits_for_configuration(record);
  if (question.empty()) {
    const UsedConfiguration used{description_.hash, clock_->now().utc};
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await writer_.configurations().continue_run(record.id, used));
  }
  const bool was_paused = record.state == RunState::paused;  // then resume_run refuses meanwhile
  engine_.begin(std::move(record), std::move(plan), std::move(trajectory), std::move(before),
                false);
  if (!question.empty() && !was_paused)
    engine_.control()->hold(
        {RunHold::Kind::configuration, "", clock_->now().utc, std::move(question)});
  co_return Result<void>{};
}

Awaitable<Result<RunBefore>> CellApplication::what_was_before(const RunRecord& run) {
  const bool killed = run.reason != kShutDownReason && run.state != RunState::paused;
  co_return co_await reader_.call([killed, id = run.id](Store& store) -> Result<RunBefore> {
    constexpr int kPage = 1000;
    RunBefore before;
    before.killed = killed;
    DRIFTWISE_TRY(auto attempts, store.runs().attempts(id));
    before.attempts = std::move(attempts);
    DRIFTWISE_TRY(auto data, store.runs().data(id));
    before.data = std::move(data);
    for (std::int64_t after = 0;;) {
      DRIFTWISE_TRY(auto page, store.runs().points(id, after, kPage));
      if (page.empty()) break;
      after = page.back().id.value;
      for (auto& point : page)
        if (point.zero) before.zeros.push_back(std::move(point));
    }
    return before;
  });
}

Awaitable<void> CellApplication::shut_down() {
  constexpr auto kPatience =
      std::chrono::seconds(2);  // wall: then whatever is still talking is cut off
  events_.record_own("daemon.stopping", "the daemon was asked to end");
  if (auto* control = engine_.control()) control->shut_down();
  if (by_hand_) by_hand_->shut_down();
  wall_clock_.shut_down();
  stops_.shut_down();
  keeper_.shut_down();
  ending_ = true;
  pauses_.shut_down();
  stop_events_.shut_down();
  alarms_end_.raise();
  recorder_.shut_down();
  serving_.shut_down();
  improver_.shut_down();
  desk_.shut_down();
  study_desk_.shut_down();
  upkeep_.shut_down();
  asio::steady_timer cut_off(executor_, kPatience);
  cut_off.async_wait([this](const boost::system::error_code& error) {
    if (!error) bench_.close_all();
  });
  co_await tasks_.all_ended();
  cut_off.cancel();
  events_.shut_down();
  if (auto ok = co_await writer_.flush(); !ok)
    spdlog::error("the last readings are not stored: {}", ok.error().message);
  co_await events_.written();
  bench_.close_all();
}

CellStatus CellApplication::status() const {
  CellStatus status;
  status.name = description_.name;
  status.version = version_;
  status.config_hash = description_.hash;
  status.web_address = web_address_;
  status.now = clock_->now();
  status.utc_offset = Nanoseconds(clock_->utc(status.now.utc).ns - status.now.utc.utc_ns);
  status.speed = clock_->speed();
  status.devices = bench_.status();
  for (const auto& latest : recorder_.history().latest()) {
    auto channel = parse_channel(latest.channel);
    if (!channel) continue;
    const auto* device = description_.find_device(latest.device);
    const bool never = latest.at.utc_ns == 0;
    const double age_s = never ? 0 : seconds_from(status.now.utc - latest.at);
    // What a person said holds until he says something else; the pose belongs to no one device.
    const double max_age_s = device                             ? device->max_age_s
                             : latest.device == kOperatorDevice ? age_s
                                                                : DeviceDescription{}.max_age_s;
    status.values.push_back(
        {*channel, latest.value, latest.at, age_s, never || age_s > max_age_s, latest.device});
  }
  if (engine_.busy()) status.run = engine_.progress();
  status.lease = leases_.present(status.now.utc);
  status.serving = serving_.model();
  status.database = upkeep_.health();
  status.attention = attention();
  status.longest_pause_s = pauses_.longest_s();
  status.recent_pause_s = pauses_.recent_s();
  status.pending_stops = stops_.records();
  return status;
}

std::vector<std::string> CellApplication::attention() const {
  std::vector<std::string> sentences;
  for (auto& stop : stops_.unconfirmed()) sentences.push_back(std::move(stop.sentence));
  for (const auto& id : bench_.lost())
    sentences.push_back(fmt::format("device {} does not answer", id));
  if (const auto* run = engine_.record(); run && run->state == RunState::waiting)
    sentences.push_back(fmt::format("run {} waits: {}", run->id.value, run->reason));
  if (auto question = configuration_.question(); !question.empty())
    sentences.push_back(std::move(question));
  if (!by_hand_waits_.empty()) sentences.push_back(by_hand_waits_);
  if (!motion_trouble_.empty()) sentences.push_back(motion_trouble_);
  if (!datum_trouble_.empty()) sentences.push_back(datum_trouble_);
  if (serving_.refused()) sentences.push_back(serving_.refused()->message);
  if (!serving_.trouble().empty()) sentences.push_back(serving_.trouble());
  if (!check_trouble_.empty()) sentences.push_back(check_trouble_);
  for (const auto& condition : upkeep_.conditions()) sentences.push_back(condition.message);
  if (writer_.dropped() > 0)
    sentences.push_back(
        fmt::format("{} slow readings were dropped: nothing could be written", writer_.dropped()));
  return sentences;
}

CellApplication::Watch CellApplication::watch_progress(
    std::function<void(const RunProgress&)> on_change) {
  if (engine_.progress()) on_change(*engine_.progress());
  return engine_.watchers().add(std::move(on_change));
}
CellApplication::Watch CellApplication::watch_events(
    std::function<void(const EventRecord&)> on_event) {
  return events_.watchers().add(std::move(on_event));
}
CellApplication::Watch CellApplication::watch_readings(
    std::function<void(const Reading&)> on_reading) {
  return recorder_.watchers().add(std::move(on_reading));
}
CellApplication::Watch CellApplication::watch_snapshots(std::function<void()> on_rebuilt) {
  on_rebuilt();
  return serving_.watchers().add(std::move(on_rebuilt));
}

}  // namespace driftwise::application
