// What those who watch ask: records, alarms, series, kept trajectories.

#include <fmt/format.h>

#include <algorithm>

#include "server/application/cell/cell_application.h"
#include "server/core/ports/spawn.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"

namespace driftwise::application {

Awaitable<Result<RecordHead>> CellApplication::record_head() {
  return reader_.call([](Store& store) -> Result<RecordHead> {
    DRIFTWISE_TRY(auto database, store.records().database_id());
    DRIFTWISE_TRY(const auto newest, store.records().newest());
    return RecordHead{std::move(database), newest};
  });
}

Awaitable<Result<RecordPage>> CellApplication::records(RecordCursor after, RecordCursor until,
                                                       int limit) {
  return reader_.records().records(after, until, limit);
}

std::shared_ptr<void> CellApplication::watch_records(std::function<void()> on_news) {
  auto watches = std::make_shared<std::vector<std::shared_ptr<void>>>();
  watches->push_back(events_.watchers().add([on_news](const EventRecord&) { on_news(); }));
  watches->push_back(engine_.watchers().add([on_news](const RunProgress&) { on_news(); }));
  watches->push_back(alarm_book_.watchers().add([on_news](const AlarmRecord&) { on_news(); }));
  // What a diagnosis tells of its progress is on no record: only its end is.
  watches->push_back(desk_.watchers().add([on_news](const DiagnosisProgress& progress) {
    if (progress.state != JobState::running) on_news();
  }));
  watches->push_back(
      improver_.watchers().add([on_news](const ImprovementProgress&) { on_news(); }));
  return watches;
}

Awaitable<Result<std::vector<AlarmRecord>>> CellApplication::alarms(bool with_history, int limit) {
  auto alarms = co_await reader_.alarms().alarms(with_history, limit);
  if (!alarms) co_return alarms;
  // While the disk is full these stand nowhere else.
  for (auto& alarm : alarm_book_.unstored()) alarms->insert(alarms->begin(), std::move(alarm));
  if (alarms->size() > static_cast<std::size_t>(std::max(limit, 0)))
    alarms->resize(static_cast<std::size_t>(std::max(limit, 0)));
  co_return alarms;
}

Awaitable<Result<AlarmRecord>> CellApplication::acknowledge_alarm(Caller caller, AlarmId id) {
  auto storing = alarm_book_.acknowledge(id, caller.name);
  auto alarm = co_await std::move(storing);
  if (alarm)
    events_.record(caller, "alarm.acknowledged",
                   fmt::format("alarm {}, {}: {}", id.value, alarm->kind, alarm->message));
  co_return alarm;
}

// Every two seconds of cell time, and at most twice a second of wall time.
Awaitable<void> CellApplication::look_for_alarms() {
  if (const auto restored = co_await alarm_book_.restore(); !restored)
    events_.record_own("daemon.trouble", "reading the alarms: " + restored.error().message);
  while (!ending_) {
    note_clock_jumps();
    auto looking = alarm_book_.look(incidents_.group(alarms_now(), clock_->now().utc));
    co_await std::move(looking);
    const double seconds = std::max(2.0, 0.5 * clock_->speed());
    co_await sleep_unless(*clock_, clock_->now().utc + nanoseconds_from_s(seconds), alarms_end_);
  }
}

void CellApplication::note_clock_jumps() {
  for (const auto& device : bench_.status()) {
    auto& known = clock_jumps_[device.description.id];
    if (device.health.clock_jumps == known) continue;
    known = device.health.clock_jumps;
    events_.record_own(
        "device.clock_jumped",
        fmt::format("the clock of {} was set by {:+.3f} s: a point under way is repeated, later "
                    "readings count by the new offset",
                    device.description.id, seconds_from(device.health.last_clock_jump)));
  }
}

std::vector<AlarmCondition> CellApplication::alarms_now() const {
  std::vector<AlarmCondition> out = alarm_conditions(status());
  // Channels that a run has just given back are read again within their period.
  if (const auto& last = engine_.progress(); last && !engine_.busy())
    std::erase_if(out, [&](const AlarmCondition& one) {
      const auto* device =
          one.kind == "channel.stale" ? description_.find_device(one.device) : nullptr;
      return device != nullptr && measures_pose(device->role()) &&
             seconds_from(clock_->now().utc - last->run.ended) <= device->max_age_s;
    });
  for (auto& stop : stops_.unconfirmed())
    out.push_back(
        {AlarmLevel::failed, "stop.unconfirmed", stop.controller, std::move(stop.sentence)});
  for (auto& doubt : doubts_.conditions()) {
    for (const auto& latest : recorder_.history().latest())
      if (latest.channel == doubt.subject) doubt.device = latest.device;
    out.push_back(std::move(doubt));
  }
  if (const auto* run = engine_.record(); run && engine_.busy())
    if (const auto trend = quality_.condition(rules_of(*run).max_spread_nm)) out.push_back(*trend);
  if (!engine_.announcement().empty())
    out.push_back({AlarmLevel::failed, "run.moves_soon",
                   fmt::format("run {}", engine_.record()->id.value), engine_.announcement()});
  // While a run works the force is the run's; after a stop, an abort or a failure nothing takes it
  // off by itself.
  const auto acts_n = force_now();
  if (acts_n && !same_force(*acts_n, 0) && (!engine_.busy() || engine_.stands()) && !by_hand_)
    out.push_back({AlarmLevel::warning, "load.on", "force",
                   fmt::format("{:.6g} N act on the robot and nothing takes them off by itself: {}",
                               *acts_n, hang_sentence(0, *description_.load))});
  if (!motion_trouble_.empty())
    out.push_back({AlarmLevel::failed, "motion.uncommanded", "axes", motion_trouble_});
  if (serving_.refused())
    out.push_back(
        {AlarmLevel::failed, "model.damaged", "served model", serving_.refused()->message});
  if (!serving_.trouble().empty())
    out.push_back({AlarmLevel::warning, "serving.trouble", "served model", serving_.trouble()});
  if (!check_trouble_.empty())
    out.push_back({AlarmLevel::warning, "model.doubtful", "served model", check_trouble_});
  if (auto question = configuration_.question(); !question.empty())
    out.push_back({AlarmLevel::warning, "configuration.changed", "cell file", std::move(question)});
  for (auto& condition : upkeep_.conditions()) out.push_back(std::move(condition));
  if (writer_.dropped() > 0)
    out.push_back({AlarmLevel::failed, "record.dropped", "database",
                   "slow readings were dropped because nothing could be written: make room on the "
                   "disk; the record says from when to when"});
  return out;
}

void CellApplication::note_for_alarms(const RunProgress& progress) {
  quality_.take(progress);
  const RunRecord& run = progress.run;
  if (run.state != RunState::failed || last_failed_ == run.id) return;
  last_failed_ = run.id;
  spawn(executor_,
        alarm_book_.note({AlarmLevel::failed, "run.failed", fmt::format("run {}", run.id.value),
                          fmt::format("run {} failed: {}", run.id.value, run.reason)}));
}

Awaitable<Result<SeriesAnswer>> CellApplication::series(SeriesQuery query) {
  return reader_.series().series(query);
}

Awaitable<Result<PastTargets>> CellApplication::past_targets(PastTargetsQuery query) {
  return serving_.past(std::move(query));
}

Awaitable<Result<KeptTrajectory>> CellApplication::keep_trajectory(Caller caller, std::string name,
                                                                   std::string text) {
  auto checking = check_trajectory(text);
  DRIFTWISE_CO_TRY(const auto checked, co_await std::move(checking));
  KeptTrajectory wanted;
  wanted.name = name;
  wanted.text = text;
  wanted.hash = formats::content_hash(text);
  wanted.rows = static_cast<std::int64_t>(checked.trajectory.points.size());
  wanted.created = clock_->now().utc;
  wanted.created_by = caller.name;
  auto kept = co_await writer_.trajectories().keep(wanted);
  if (kept && kept->created.utc_ns == wanted.created.utc_ns)
    events_.record(caller, "trajectory.kept",
                   fmt::format("trajectory {} '{}', {} rows", kept->id.value, name, wanted.rows));
  co_return kept;
}

Awaitable<Result<KeptTrajectory>> CellApplication::trajectory(TrajectoryId id) {
  return reader_.trajectories().trajectory(id);
}

Awaitable<Result<std::vector<KeptTrajectory>>> CellApplication::trajectories() {
  return reader_.trajectories().trajectories();
}

}  // namespace driftwise::application
