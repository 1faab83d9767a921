#include "server/application/alarms/alarms_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/commissioning/device_checks.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/recording/doubts.h"
#include "server/core/ports/spawn.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr const char* kUnwritten = "record.unwritten";

// At most as many, in their order, newest first. what_is_over_goes_first: before what holds.
void leave_newest(std::vector<AlarmRecord>& alarms, std::size_t most,
                  bool what_is_over_goes_first) {
  const auto holds = [](const AlarmRecord& alarm) { return alarm.cleared.utc_ns == 0; };
  if (what_is_over_goes_first && alarms.size() > most) {
    const auto holding = static_cast<std::size_t>(std::ranges::count_if(alarms, holds));
    std::size_t room = most - std::min(most, holding);
    std::erase_if(alarms, [&](const AlarmRecord& alarm) {
      if (holds(alarm)) return false;
      if (room == 0) return true;
      --room;
      return false;
    });
  }
  if (alarms.size() > most) alarms.resize(most);
}

}  // namespace

AlarmsService::AlarmsService(asio::any_io_executor executor, Sources sources, StoreReader& reader,
                             AlarmBook& book, TaskGroup& tasks)
    : executor_(executor),
      description_(sources.bench.description),
      clock_(sources.bench.clock),
      bench_(sources.bench.devices),
      recorder_(sources.bench.recorder),
      writer_(sources.bench.writer),
      events_(sources.bench.events),
      loading_(sources.bench.loading),
      stops_(sources.bench.stops),
      doubts_(sources.bench.doubts),
      overview_(sources.overview),
      engine_(sources.engine),
      right_(sources.right),
      manual_(sources.manual),
      serving_(sources.serving),
      checks_(sources.checks),
      configuration_(sources.configuration),
      upkeep_(sources.upkeep),
      access_(sources.access),
      notify_(sources.notify),
      holds_(sources.holds),
      queue_(sources.queue),
      reader_(reader),
      book_(book),
      tasks_(tasks),
      channel_alarms_(description_.channel_alarms),
      wake_(executor) {}

void AlarmsService::start() { tasks_.spawn(look_for_ever()); }

void AlarmsService::shut_down() {
  ending_ = true;
  wake_.raise();
}

void AlarmsService::note(AlarmCondition condition) {
  spawn(executor_, book_.note(std::move(condition)));
}

Awaitable<Result<std::vector<AlarmRecord>>> AlarmsService::list(bool with_history, int limit) {
  // While the disk is full these stand nowhere else. Asked before the record is: what is stored
  // meanwhile is in both.
  auto unstored = book_.unstored();
  auto alarms = co_await reader_.alarms().alarms(with_history, limit);
  if (!alarms) co_return alarms;
  std::erase_if(unstored, [&](const AlarmRecord& one) {
    return std::ranges::any_of(*alarms, [&](const AlarmRecord& stored) {
      return stored.since == one.since && stored.kind == one.kind && stored.subject == one.subject;
    });
  });
  for (auto& now : book_.outdated())
    for (auto& alarm : *alarms)
      if (alarm.id == now.id) alarm = now;
  if (!with_history)
    std::erase_if(*alarms, [](const AlarmRecord& alarm) {
      return alarm.cleared.utc_ns != 0 && alarm.acknowledged.utc_ns != 0;
    });
  for (auto& alarm : unstored) alarms->insert(alarms->begin(), std::move(alarm));
  leave_newest(*alarms, static_cast<std::size_t>(std::max(limit, 0)), !with_history);
  co_return alarms;
}

std::vector<AlarmRecord> AlarmsService::unwritten(std::size_t most) const {
  auto out = book_.outdated();
  auto unstored = book_.unstored();
  out.insert(out.end(), std::move_iterator(unstored.begin()), std::move_iterator(unstored.end()));
  if (out.size() > most) out.erase(out.begin(), out.end() - static_cast<std::ptrdiff_t>(most));
  return out;
}

Awaitable<Result<AlarmRecord>> AlarmsService::acknowledge(Caller caller, AlarmId id) {
  auto storing = book_.acknowledge(id, caller.name);
  auto alarm = co_await std::move(storing);
  if (alarm)
    events_.record(caller, "alarm.acknowledged",
                   fmt::format("alarm {}, {}: {}", id.value, alarm->kind, alarm->message));
  co_return alarm;
}

Awaitable<Result<AlarmRecord>> AlarmsService::shelve(Caller caller, AlarmId id, double for_s,
                                                     std::string reason) {
  if (!(for_s > 0) || for_s > AlarmShelf::kLongest_s || reason.empty())
    co_return fail(ErrorCode::invalid_argument, reasons::kBadShelf,
                   fmt::format("found {:g} s and {} for shelving alarm {}: expected a time above 0 "
                               "and at most 24 h, and a reason",
                               for_s, reason.empty() ? "no reason" : "a reason", id.value));
  auto storing = book_.shelve(id, for_s, caller.name, reason);
  auto alarm = co_await std::move(storing);
  if (alarm)
    events_.record(caller, "alarm.shelved",
                   fmt::format("alarm {}, {}, until {}: {}", id.value, alarm->message,
                               to_iso8601(clock_.utc(alarm->shelved_until)), reason),
                   {},
                   {fmt::format("alarm {}", id.value), "",
                    fmt::format("until {}", to_iso8601(clock_.utc(alarm->shelved_until)))});
  co_return alarm;
}

Awaitable<Result<AlarmRecord>> AlarmsService::unshelve(Caller caller, AlarmId id) {
  auto storing = book_.unshelve(id);
  auto alarm = co_await std::move(storing);
  if (alarm)
    events_.record(caller, "alarm.unshelved", fmt::format("alarm {}: {}", id.value, alarm->message),
                   {}, {fmt::format("alarm {}", id.value), "shelved", ""});
  co_return alarm;
}

void AlarmsService::look_at_channels() {
  const CellTime now = clock_.now().utc;
  for (const auto& limit : description_.channel_alarms)
    if (const auto* latest = recorder_.history().latest(limit.channel))
      channel_alarms_.take(limit.channel, latest->device, latest->value, now);
}

// Every two seconds of cell time, and at most twice a second of wall time.
Awaitable<void> AlarmsService::look_for_ever() {
  if (const auto restored = co_await book_.restore(); !restored)
    events_.record_own("daemon.trouble", "reading the alarms: " + restored.error().message);
  started_ = clock_.now().utc;
  for (const auto& alarm : book_.unjudged()) channel_alarms_.stand(alarm.kind, alarm.subject);
  while (!ending_) {
    note_clock_jumps();
    look_at_channels();
    auto ending_shelves = book_.end_shelves();
    co_await std::move(ending_shelves);
    for (const auto& alarm : book_.unjudged())
      incidents_.stand(alarm.kind, alarm.subject, alarm.since, clock_.now().utc);
    auto alarms = incidents_.group(alarms_now(), clock_.now().utc);
    // A record that takes nothing for a moment explains a run that waits; it neither begins an
    // alarm nor keeps one that stands.
    std::erase_if(alarms,
                  [](const AlarmCondition& one) { return one.kind == kUnwritten && one.settling; });
    AlarmBook::IsJudged is_judged = [this](const AlarmRecord& alarm) { return has_judged(alarm); };
    auto looking = book_.look(std::move(alarms), std::move(is_judged));
    co_await std::move(looking);
    const double seconds = std::max(2.0, 0.5 * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(seconds), wake_);
  }
}

void AlarmsService::note_clock_jumps() {
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

std::vector<AlarmCondition> AlarmsService::alarms_now() const {
  std::vector<AlarmCondition> out = alarm_conditions(overview_.status());
  const bool is_ending = holds_.settles();
  for (auto& one : out) one.is_ending = is_ending && one.kind == "run.waiting";
  // Channels that a run has just given back are read again within their period.
  if (const auto& last = engine_.progress(); last && !engine_.busy())
    std::erase_if(out, [&](const AlarmCondition& one) {
      const auto* device =
          one.kind == "channel.stale" ? description_.find_device(one.device) : nullptr;
      return device != nullptr && is_read_by_runs(device->role()) &&
             seconds_from(clock_.now().utc - last->run.ended) <= device->max_age_s;
    });
  for (auto& stop : stops_.unconfirmed())
    out.push_back(
        {AlarmLevel::failed, "stop.unconfirmed", stop.controller, std::move(stop.sentence)});
  for (auto& doubt : doubts_.conditions()) {
    for (const auto& latest : recorder_.history().latest())
      if (latest.channel == doubt.subject) doubt.device = latest.device;
    out.push_back(std::move(doubt));
  }
  if (const auto* rules = engine_.rules(); rules && engine_.busy())
    if (const auto trend = quality_.condition(rules->max_spread_nm)) out.push_back(*trend);
  if (!engine_.announcement().empty()) {
    // A start that somebody has put into the queue is expected; one after an absence is not.
    const auto& run = *engine_.record();
    const bool is_planned = run.queue_entry && run.restarts == 0;
    out.push_back({is_planned ? AlarmLevel::notice : AlarmLevel::failed,
                   is_planned ? "run.begins_soon" : "run.moves_soon",
                   fmt::format("run {}", run.id.value), engine_.announcement()});
  }
  // While a run works the force is the run's; after a stop, an abort or a failure nothing takes it
  // off by itself.
  const auto acts_n = force_now();
  if (acts_n && !same_force(*acts_n, 0) && (!engine_.busy() || engine_.stands()) &&
      !right_.by_hand())
    out.push_back({AlarmLevel::warning, "load.on", "force",
                   fmt::format("{:.6g} N act on the robot and nothing takes them off by itself: {}",
                               *acts_n, hang_sentence(0, *description_.load))});
  if (!manual_.motion_trouble().empty())
    out.push_back({AlarmLevel::failed, "motion.uncommanded", "axes", manual_.motion_trouble()});
  if (serving_.refused())
    out.push_back(
        {AlarmLevel::failed, "model.damaged", "served model", serving_.refused()->message});
  if (!serving_.trouble().empty())
    out.push_back({AlarmLevel::warning, "serving.trouble", "served model", serving_.trouble()});
  if (!checks_.trouble().empty())
    out.push_back({AlarmLevel::warning, "model.doubtful", "served model", checks_.trouble()});
  if (auto question = configuration_.question(); !question.empty())
    out.push_back({AlarmLevel::warning, "configuration.changed", "cell file", std::move(question)});
  for (auto& overdue : overdue_certificates(description_, clock_.utc(clock_.now().utc).ns))
    out.push_back({AlarmLevel::notice, "certificate.overdue", std::move(overdue.subject),
                   std::move(overdue.sentence)});
  for (auto& condition : upkeep_.conditions()) out.push_back(std::move(condition));
  for (auto& condition : notify_.conditions()) out.push_back(std::move(condition));
  for (auto& condition : channel_alarms_.conditions(clock_.now().utc))
    out.push_back(std::move(condition));
  for (auto& condition : queue_.conditions()) out.push_back(std::move(condition));
  for (auto& condition : access_.conditions()) out.push_back(std::move(condition));
  // Cell time, and at least two seconds of the wall's. Before, it explains why a run waits.
  const double unwritten_s = std::max(60.0, 2 * clock_.speed());
  if (const auto since = writer_.gathered_since())
    out.push_back({.level = AlarmLevel::failed,
                   .kind = kUnwritten,
                   .subject = "database",
                   .message =
                       "the record takes nothing: readings gather in memory, and a run under way "
                       "waits; make room on the disk, or look whether it is still there and takes "
                       "what is written (the log says)",
                   .settling = seconds_from(clock_.now().utc - *since) <= unwritten_s});
  if (writer_.is_dropping())
    out.push_back({AlarmLevel::failed, "record.dropped", "database",
                   "slow readings are dropped because nothing can be written: make room on the "
                   "disk; the event recorder.dropped will say how many"});
  if (events_.lost_acts() > 0)
    out.push_back(
        {AlarmLevel::failed, "record.dropped", "audit",
         fmt::format("{} acts of people are done and are not in the audit: {}; the log of "
                     "the daemon has each of them (journalctl -u driftwised)",
                     events_.lost_acts(), events_.lost_because())});
  return out;
}

void AlarmsService::note_progress(const RunProgress& progress) {
  quality_.take(progress);
  const RunRecord& run = progress.run;
  if (run.state != RunState::failed || last_failed_ == run.id) return;
  last_failed_ = run.id;
  spawn(executor_,
        book_.note({AlarmLevel::failed, "run.failed", fmt::format("run {}", run.id.value),
                    fmt::format("run {} failed: {}", run.id.value, run.reason)}));
}

// An actuator is asked in its period; without one a person has said it.
std::optional<double> AlarmsService::force_now() const {
  const auto channel = description_.force_channel();
  if (!channel || !description_.load) return std::nullopt;
  if (!description_.load_actuator()) return loading_.known_n();
  const auto* latest = recorder_.history().latest(channel->name());
  if (!latest || is_missing(latest->value)) return std::nullopt;
  return latest->value;
}

}  // namespace driftwise::application
