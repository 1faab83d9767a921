#include "server/application/cell/composition.h"

#include <fmt/format.h>

#include "server/application/plans/joint_rows.h"
#include "server/application/trajectories/motor_rows.h"

namespace driftwise::application {
namespace {

StoreReader::Open reading_anew(const OpenStore& open_store, const std::string& path) {
  return [open_store, path] { return open_store(path, true); };
}

// Each controller confirms a stop for itself.
std::vector<StopDesk::Controller> controllers_of(DeviceBench& bench) {
  std::vector<StopDesk::Controller> controllers;
  for (const auto device : bench.with_role(DeviceRole::motion))
    controllers.push_back({bench.description(device).id,
                           [&bench, device] { return bench.stop(device); },
                           [&bench, device] { return bench.motion_state(device); }});
  return controllers;
}

// An axis that cannot be reached is told again by the run's engine.
Awaitable<void> stop_axes(DeviceBench& bench) { static_cast<void>(co_await bench.stop()); }

}  // namespace

Composition::Composition(asio::any_io_executor on, Cell::Parts given, OpenedRecord opened)
    : executor(on),
      description(std::move(given.description)),
      configuration(std::move(opened.configuration)),
      clock(std::move(given.clock)),
      version(std::move(given.version)),
      boot_id(std::move(given.boot_id)),
      storage_thread(given.storage_thread),
      query_thread(given.query_thread),
      worker_thread(given.worker_thread),
      diagnosis_thread(given.diagnosis_thread),
      text_thread(given.text_thread),
      upkeep_thread(given.upkeep_thread),
      // One for each receiver and one for the watchdog: none waits for another.
      notify_threads(given.notify_threads, description.receivers.size() + 1),
      notifier(std::move(given.notifier)),
      host(on, text_thread.executor(), *clock),
      writer(storage_thread.executor(), std::move(opened.writing)),
      reader(on, query_thread.executor(), std::move(opened.reading),
             reading_anew(given.open_store, description.database)),
      checker(on, upkeep_thread.executor(), std::move(opened.checking),
              reading_anew(given.open_store, description.database)),
      events(on, *clock, writer),
      doubts(description, *clock, writer, events, [this] { alarms.look_now(); }),
      bench(on, std::move(given.devices), doubts,
            [this](const DeviceDescription& device, const Error* error) {
              if (error)
                events.record_own("device.lost", error->message);
              else
                events.record_own("device.back",
                                  fmt::format("{} at {} answers again", device.id, device.address));
            }),
      lag(*clock),
      pauses(on),
      tasks(on),
      stop_events(on, *clock, events, tasks),
      stops(on, *clock, writer, events, tasks, controllers_of(bench)),
      keeper(on, *clock, bench, tasks, [this] { return engine.busy() || right.by_hand(); }),
      pose(description),
      recorder(on, *clock, bench, writer, events, lag, pose, tasks),
      durations(reader),
      workbench{description, *clock, bench,   recorder, writer, events,
                lag,         pose,   loading, stops,    doubts, boot_id},
      serving(on, description, configuration, *clock, recorder, reader, events, tasks),
      joint_serving(on, description, configuration, *clock, recorder, reader, events, tasks,
                    serving),
      engine(on, workbench,
             {[this](const ActiveRun& run, const TrajectoryPoint& row) -> Result<RowCommand> {
                const auto& coordinates = run.trajectory.coordinates;
                if (!run.plan.compensate)
                  return RowCommand{motor_row(description, coordinates, row.target), row.target};
                TrajectoryPoint wanted = row;
                if (!wanted.force_n) wanted.force_n = loading.known_n();
                if (description.has_several_robots())
                  return joint_row(description, joint_serving.snapshot_now(), coordinates, wanted,
                                   clock->now().utc);
                DRIFTWISE_TRY(auto q_mm,
                              serving.targets(coordinates, wanted, run.plan.compensate_with));
                return RowCommand{std::move(q_mm), row.target};
              },
              [this](const DatumRecord& datum) { manual.take_datum(datum); },
              [this](AlarmCondition condition) { alarms.note(std::move(condition)); },
              [this](RunControl& control) { holds.look_before_motion(control); },
              [this] { return holds.take_marks(); },
              [this](const RunAhead& ahead) { return durations.look_ahead(ahead); },
              [this](RunSteps steps) { durations.add(std::move(steps)); },
              [this](const std::vector<ChannelValue>& values) {
                return model_pose(serving.snapshots(), values);
              }},
             tasks),
      leases([this](CellTime instant) { return clock->utc(instant); }),
      right(on, *clock, stops, leases, engine),
      alarm_book(*clock, writer),
      notify(on,
             {*clock, writer, reader, events, tasks, alarm_book.watchers(), notifier.get(),
              notify_threads.executor(), [this] { return alarm_book.unstored(); }},
             {description.name, version,
              given.web_address_outside.empty() ? given.web_address : given.web_address_outside,
              description.receivers, description.watchdog},
             [this](LifeSign& sign) {
               const auto* run = engine.record();
               const bool under_way = run != nullptr && engine.busy();
               sign.run = under_way ? run->id.value : 0;
               sign.run_state = under_way ? std::string(to_string(run->state)) : "idle";
             }),
      diagnosis_desk(on, diagnosis_thread.executor(), *clock, writer, events, tasks,
                     std::move(given.diagnose)),
      study_desk(on, diagnosis_thread.executor(), tasks),
      wall_clock(on, *clock, writer, events, tasks,
                 [this](AlarmCondition condition) { alarms.note(std::move(condition)); }),
      clock_start(std::move(opened.clock_start)),
      upkeep(
          on, *clock, description.database, writer, {&reader}, &checker, events, tasks,
          [this] { return engine.busy() || right.by_hand() != nullptr; }, description.backup,
          description.thinning),
      access(on, text_thread.executor(), description.access, *clock, events, tasks),
      holds(on, description, *clock, recorder, events, tasks,
            {[this] { return engine.control(); }, [this] { return engine.measures(); },
             given.end_daemon ? std::move(given.end_daemon) : [] {},
             [this] { return upkeep.disk_free_gb(); },
             // A movement by hand beside a run that stands is a person's.
             [this] {
               if (!right.by_hand()) tasks.spawn(stop_axes(bench));
             }}),
      trajectories(description, *clock, writer, events, text_thread.executor(), durations),
      datasets(description, *clock, reader, writer, events, text_thread.executor()),
      annotations(*clock, reader, writer, events),
      models(description, *clock, reader, writer, events, datasets, worker_thread.executor()),
      provenance(description, *clock, reader),
      checks(worker_thread.executor(), reader, events, serving, tasks),
      promotions(executor, *clock, reader, writer, events, models, provenance, serving,
                 [this](bool any) { checks.served_another(any); }),
      runs(workbench, reader, engine, right, stop_events, trajectories, models, serving,
           joint_serving, configuration, text_thread.executor()),
      manual(on, workbench, reader, engine, right, leases, stop_events, serving, tasks,
             [this](const std::string& why) { improver.halt(why); }),
      configurations(description, *clock, reader, writer, events, configuration, engine, serving),
      diagnoses(description, reader, diagnosis_desk, datasets, models, serving,
                text_thread.executor()),
      extensions(executor, description, *clock, reader, writer, events, diagnoses, models,
                 promotions, serving, worker_thread.executor()),
      improver(
          on,
          {trajectories, manual, runs, models, checks, promotions, diagnoses, extensions, serving},
          *clock, writer, events, tasks),
      improvements(description, reader, right, trajectories, diagnoses, improver),
      studies(description, datasets, study_desk),
      overview({version, std::move(given.web_address)},
               {workbench, engine, leases, manual, serving, checks, configuration, upkeep, pauses,
                notify}),
      alarms(on,
             {workbench, overview, engine, right, manual, serving, checks, configuration, upkeep,
              access, notify, holds, queue_desk},
             reader, alarm_book, tasks),
      feeds(events, recorder, engine, alarm_book, diagnosis_desk, improver),
      reports(
          {workbench, reader, runs, provenance, checks, models, diagnoses, text_thread.executor()},
          version, std::move(given.report_template)),
      queue_desk(on, {description, *clock, recorder, reader, writer, events, runs, engine, right,
                      stops, durations, leases, models, diagnoses, reports, tasks,
                      text_thread.executor(), [this] { return improver.busy(); },
                      [this](AlarmCondition condition) { alarms.note(std::move(condition)); }}),
      queue(description, *clock, events, trajectories, models, queue_desk),
      plans(executor, description, *clock, reader, writer, events, models, provenance,
            joint_serving, worker_thread.executor()),
      jogs(on, workbench, engine, right, leases, tasks, given.measure_pauses),
      rests(on, *clock, recorder, writer, events, engine, right, tasks),
      commissioning(workbench, reader, writer, engine, rests, worker_thread.executor()),
      look_back(workbench, reader, datasets, models, worker_thread.executor()),
      indentations(*clock, reader, writer, events, text_thread.executor()),
      support({given.schema_version, std::move(given.log_tail)}, workbench, reader, overview,
              text_thread.executor()),
      measure_pauses_(given.measure_pauses),
      looked_for_what_serves_(this->executor) {
  stops.restore(std::move(opened.stops));
  stops.tell_presses([this](const Caller& caller, const std::string& cause) {
    queue_desk.stopped(caller, cause);
  });
  queue_desk.restore(std::move(opened.queue));
  if (given.kept_stop)
    events.record_own(
        "stop.kept",
        fmt::format("stopped by {} at {} by the clock there, while no daemon answered: "
                    "the axes are stopped now, and a run that was under way waits for "
                    "a person",
                    given.kept_stop->who, given.kept_stop->asked));
  manual.start();
  if (!opened.interrupted_improvement.empty())
    events.record_own("improvement.failed", opened.interrupted_improvement);
  if (opened.unfinished_jobs > 0)
    events.record_own("diagnosis.failed",
                      fmt::format("{} of the diagnoses and improvements were under way when the "
                                  "daemon ended: they have failed; their runs stay",
                                  opened.unfinished_jobs));
}

Composition::~Composition() {
  // Nothing of ours may run on a thread of its own while members go.
  storage_thread.join();
  query_thread.join();
  worker_thread.join();
  diagnosis_thread.join();
  text_thread.join();
  upkeep_thread.join();
  notify_threads.join();
}

Services Composition::services() {
  return {host,       overview,       reader,    manual,        runs,         trajectories,
          datasets,   annotations,    models,    promotions,    checks,       serving,
          provenance, configurations, diagnoses, extensions,    improvements, studies,
          alarms,     feeds,          queue,     upkeep,        holds,        notify,
          plans,      joint_serving,  jogs,      commissioning, look_back,    support,
          reports,    indentations};
}

}  // namespace driftwise::application
