#include "server/application/queue/queue_desk.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/store_refusal.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::application {
namespace {

constexpr double kLookEvery_s = 5;

// Errors of a start that say nothing of the entry: it is tried again.
bool is_passing(const Error& error) {
  static const std::string passing[] = {reasons::kLeaseHeld,     reasons::kLeaseExpired,
                                        reasons::kLeaseRequired, reasons::kLeaseUnknown,
                                        reasons::kRunUnderWay,   reasons::kMoving,
                                        reasons::kStopPending,   reasons::kStoppedMeanwhile};
  return may_be_stored_later(error) || error.code == ErrorCode::cancelled ||
         std::ranges::find(passing, error.reason) != std::end(passing);
}

// Draws on another thread: the history stays as it is for whoever holds it.
Outlook drawn_from(const std::shared_ptr<const DurationHistory>& history, const RunAhead& ahead) {
  return look_ahead(*history, ahead);
}

}  // namespace

QueueDesk::QueueDesk(asio::any_io_executor executor, Parts parts)
    : executor_(executor), parts_(std::move(parts)), changing_(executor), wake_(executor) {}

void QueueDesk::start() {
  run_watch_ = parts_.runs.watch([this](const RunProgress& progress) {
    if (!is_over(progress.run.state)) return;
    woken_ = true;
    wake_.raise();
  });
  parts_.tasks.spawn(look_for_ever());
}

void QueueDesk::shut_down() {
  ending_ = true;
  run_watch_.reset();
  wake_.raise();
}

void QueueDesk::stopped(const Caller& caller, const std::string& cause) {
  last_stop_ = {true, caller.name, cause, parts_.clock.now().utc};
  ++stops_;
  if (!record_.hold.held) hold_by_stop();  // else the first one's words stay, as in the store
}

void QueueDesk::hold_by_stop() {
  record_.hold = last_stop_;
  parts_.events.record_own("queue.held", "the queue is held: " + last_stop_.why);
}

void QueueDesk::look_now() {
  asked_ = woken_ = true;
  wake_.raise();
}

QueueEntryId QueueDesk::next_id() const {
  std::int64_t newest = 0;
  for (const auto& entry : record_.entries) newest = std::max(newest, entry.id.value);
  return {newest + 1};
}

std::int64_t QueueDesk::first_place() const {
  const auto waiting = waiting_in_order(record_.entries);
  std::int64_t first = 1;
  for (const auto* entry : waiting) first = std::min(first, entry->place);
  return first;
}

std::int64_t QueueDesk::last_place() const {
  std::int64_t last = 0;
  for (const auto* entry : waiting_in_order(record_.entries)) last = std::max(last, entry->place);
  return last;
}

// The name is known by the entry: how its author was proved stands in the audit of queue.added.
Caller QueueDesk::in_the_name_of(const QueueEntry& entry) {
  std::string by_entry = fmt::format("queue entry {}", entry.id.value);
  return {entry.created_by, by_entry, by_entry};
}

Awaitable<Result<void>> QueueDesk::change(QueueChange change) {
  const auto stops_before = stops_;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await parts_.writer.queue().change_queue(change));
  for (auto& entry : change.put) {
    if (is_over(entry.state)) entry.trajectory_text.clear();
    if (entry.state != QueueState::waiting) {
      conditions_.erase(entry.id);
      refused_.erase(entry.id);
    }
    const auto found = std::ranges::find(record_.entries, entry.id, &QueueEntry::id);
    if (found == record_.entries.end())
      record_.entries.push_back(std::move(entry));
    else
      *found = std::move(entry);
  }
  forget_old_entries(record_.entries, kHistory);
  if (!change.hold) co_return Result<void>{};
  record_.hold = *std::move(change.hold);
  // A stop that came meanwhile is in force, and the store has it after this change.
  if (stops_ != stops_before && !record_.hold.held) hold_by_stop();
  co_return Result<void>{};
}

std::string QueueDesk::busy() const {
  if (auto ok = parts_.stops.check(); !ok) return ok.error().message;
  if (const auto* run = parts_.engine.record())
    return fmt::format("run {} '{}' {}", run->id.value, run->name, is_text(run->state));
  if (parts_.right.by_hand()) return "a movement by hand is under way";
  if (parts_.improving()) return "an improvement is under way";
  if (const auto lease = parts_.leases.present(parts_.clock.now().utc))
    return fmt::format("{} holds the lease to move until {}", lease->holder,
                       to_iso8601(parts_.clock.utc(lease->until)));
  return {};
}

QueueSituation QueueDesk::situation() const {
  return {&record_.entries, record_.hold, parts_.clock.utc(parts_.clock.now().utc), busy(),
          conditions_};
}

std::map<QueueEntryId, std::string> QueueDesk::waits() const {
  auto turn = decide_turn(situation());
  if (!turn.starts) return std::move(turn.waits);
  const auto why = refused_.find(*turn.starts);
  turn.waits[*turn.starts] = why == refused_.end() ? "starts now" : "waits: " + why->second;
  return std::move(turn.waits);
}

std::string QueueDesk::waits_for(QueueEntryId id) const {
  const auto all = waits();
  const auto found = all.find(id);
  return found == all.end() ? std::string() : found->second;
}

std::map<QueueEntryId, EntryOutlook> QueueDesk::outlooks(std::optional<QueueEntryId> only) const {
  QueueAhead ahead;
  ahead.entries = &record_.entries;
  ahead.held = record_.hold.held;
  ahead.stands = parts_.engine.stands();
  ahead.now = parts_.clock.now().utc;
  ahead.cell_time = [this](UtcTime utc) { return parts_.clock.cell_time(utc); };
  ahead.lengths = &lengths_;
  ahead.under_way = parts_.engine.outlook(ahead.now);
  ahead.only = only;
  return look_ahead(ahead);
}

// What the length of each entry that waits is drawn from, from its trajectory.
Awaitable<void> QueueDesk::read_plans() {
  std::erase_if(lengths_, [this](const auto& length) {
    const auto* entry = find_entry(record_.entries, length.first);
    return !entry || entry->state != QueueState::waiting;
  });
  std::vector<std::pair<QueueEntryId, std::string>> missing;
  for (const auto& entry : record_.entries)
    if (entry.state == QueueState::waiting && !lengths_.contains(entry.id))
      missing.emplace_back(entry.id, entry.trajectory_text);
  for (auto& [id, text] : missing) {
    const auto trajectory = co_await run_on(parts_.background, formats::read_trajectory_csv,
                                            std::move(text), std::string("trajectory"));
    const auto plan = trajectory ? PlanLength(*trajectory).ahead({}) : PlanAhead{};
    if (const auto* entry = find_entry(record_.entries, id))
      lengths_[id].ahead = run_ahead(*entry, plan, parts_.description.run);
  }
}

// Draws of each entry that waits: of one that is new, and of all once a run has ended. A list and a
// start do not wait for them: until they are there, those of the history before count.
Awaitable<void> QueueDesk::draw_lengths() {
  while (!ending_) {
    const auto history = parts_.durations.history();
    const auto due = std::ranges::find_if(
        lengths_, [&history](const auto& length) { return length.second.history != history; });
    if (due == lengths_.end()) break;
    const auto id = due->first;
    const auto ahead = due->second.ahead;
    auto run = co_await run_on(parts_.background, drawn_from, history, ahead);
    const auto drawn = lengths_.find(id);
    if (drawn == lengths_.end()) continue;
    drawn->second.history = history;
    drawn->second.run = std::move(run);
  }
  drawing_ = false;
}

Awaitable<void> QueueDesk::look_for_ever() {
  while (!ending_) {
    woken_ = false;
    {
      const auto lock = co_await changing_.lock();
      if (!ending_) co_await look();
    }
    if (woken_ || ending_) continue;
    const double pause_s = std::max(kLookEvery_s, 0.25 * parts_.clock.speed());
    co_await sleep_unless(parts_.clock, parts_.clock.now().utc + nanoseconds_from_s(pause_s),
                          wake_);
  }
}

Awaitable<void> QueueDesk::look() {
  const bool asked_for = std::exchange(asked_, false);
  const auto running = std::ranges::find(record_.entries, QueueState::running, &QueueEntry::state);
  if (running != record_.entries.end()) {
    auto settling = settle(*running);
    co_await std::move(settling);
  }
  if (!following_) {
    const auto next = std::ranges::find(record_.entries, QueueState::following, &QueueEntry::state);
    if (next != record_.entries.end()) {
      following_ = true;
      parts_.tasks.spawn(follow(next->id));
    }
  }
  co_await read_plans();
  if (!std::exchange(drawing_, true)) parts_.tasks.spawn(draw_lengths());
  std::vector<std::pair<QueueEntryId, std::string>> conditions;
  for (const auto* entry : waiting_in_order(record_.entries))
    if (!entry->condition.empty()) conditions.emplace_back(entry->id, entry->condition);
  for (const auto& [id, text] : conditions) {
    auto looking = look_at(text);
    auto verdict = co_await std::move(looking);
    conditions_[id] = verdict ? *verdict : ConditionVerdict{false, verdict.error().message};
  }
  if (ending_) co_return;
  const auto turn = decide_turn(situation());
  if (!turn.starts) co_return;
  if (const auto* entry = find_entry(record_.entries, *turn.starts))
    co_await begin(*entry, asked_for);
}

Awaitable<Result<ConditionVerdict>> QueueDesk::look_at(std::string text) {
  DRIFTWISE_CO_TRY(const auto condition,
                   parse_condition(text, channels_for_conditions(parts_.description)));
  const auto now = parts_.clock.now().utc;
  ConditionRecord record;
  const auto name = condition.channel.name();
  if (const auto* newest = parts_.recorder.history().latest(name)) {
    record.newest = newest->value;
    record.age_s = seconds_from(now - newest->at);
    if (const auto* device = parts_.description.find_device(newest->device))
      record.most_age_s = std::max(record.most_age_s, device->max_age_s);
  }
  if (condition.span_s > 0) {
    SeriesQuery query;
    query.channels = {name};
    query.from = now - nanoseconds_from_s(condition.span_s);
    query.to = now;
    query.buckets = buckets_for(condition);
    auto asking = parts_.reader.series().series(std::move(query));
    if (auto series = co_await std::move(asking)) record.series = *std::move(series);
  }
  co_return judge(condition, record, now);
}

Awaitable<void> QueueDesk::begin(QueueEntry entry, bool asked_for) {
  constexpr std::chrono::seconds kLease{60};
  const auto caller = in_the_name_of(entry);
  const Caller holder{fmt::format("the queue for {}", entry.created_by), caller.peer, caller.proof};
  auto lease = parts_.leases.take(holder, kLease, "", parts_.clock.now().utc);
  if (!lease) {
    refused_[entry.id] = lease.error().message;
    co_return;
  }
  CreateRun wanted;
  wanted.name = entry.name;
  wanted.trajectory_name = entry.trajectory_name;
  wanted.trajectory_text = entry.trajectory_text;
  wanted.lease_token = lease->token;
  wanted.compensate = entry.compensate;
  wanted.compensate_with = entry.compensate_with;
  wanted.metadata = entry.metadata;
  wanted.queue_entry = entry.id;
  if (!asked_for) wanted.announce = fmt::format("the queue begins {}", entry_text(entry));
  if (!entry.rules_json.empty())
    if (auto plan = read_run_plan(entry.rules_json)) {
      if (states_rules(entry.rules_json)) wanted.rules = plan->rules;
      wanted.setup = plan->setup;
    }
  auto creating = parts_.runs.create(caller, std::move(wanted));
  const auto run = co_await std::move(creating);
  static_cast<void>(parts_.leases.give_up(lease->token, parts_.clock.now().utc));
  if (!run) {
    refused_[entry.id] = run.error().message;
    if (!is_passing(run.error())) {
      auto putting = put_back(std::move(entry), run.error().message, false);
      co_await std::move(putting);
    }
    co_return;
  }
  refused_.erase(entry.id);
  parts_.events.record_own(
      "queue.began", fmt::format("{} began as run {}", entry_text(entry), run->id.value), run->id);
  // The store did the same with the run.
  const auto found = std::ranges::find(record_.entries, entry.id, &QueueEntry::id);
  found->state = QueueState::running;
  found->reason.clear();
  found->run = run->id;
  found->begun = run->created;
  found->ended = {};
  if (!record_.hold.held) co_return;
  auto pausing =
      parts_.runs.pause({record_.hold.who, caller.peer, "queue hold"}, run->id);  // meanwhile
  static_cast<void>(co_await std::move(pausing));
}

Awaitable<void> QueueDesk::settle(QueueEntry entry) {
  auto looking = parts_.runs.get(*entry.run);
  const auto run = co_await std::move(looking);
  if (!run || !is_over(run->state)) co_return;
  if (run->state != RunState::done) {
    auto why = fmt::format("run {} {}: {}", run->id.value, to_string(run->state), run->reason);
    entry.ended = run->ended;
    auto putting = put_back(std::move(entry), std::move(why), run->state == RunState::aborted);
    co_await std::move(putting);
    co_return;
  }
  entry.ended = run->ended;
  entry.results.clear();
  entry.state = entry.follow_ups.empty() ? QueueState::done : QueueState::following;
  QueueChange settled;
  add_repeat(entry, settled);
  auto detail = fmt::format("{} is done: run {}, {} of {} rows accepted", entry_text(entry),
                            run->id.value, run->accepted, run->rows);
  settled.put.push_back(std::move(entry));
  auto changing = change(std::move(settled));
  if (co_await std::move(changing))
    parts_.events.record_own("queue.done", std::move(detail), run->id);
}

// A run that failed, was aborted, or was refused.
Awaitable<void> QueueDesk::put_back(QueueEntry entry, std::string why, bool by_person) {
  const bool sets_aside = entry.on_failure == OnFailure::set_aside && !by_person;
  const auto text = entry_text(entry);
  const auto run = entry.run;
  QueueChange settled;
  entry.reason = why;
  if (sets_aside) {
    entry.state = QueueState::set_aside;
    add_repeat(entry, settled);
    entry.repeat_every_s = 0;  // the next one has it: back in the queue this one runs once
  } else {
    entry.state = QueueState::waiting;
    entry.place = first_place() - 1;
    if (!record_.hold.held)
      settled.hold = QueueHold{true, "", fmt::format("{}: {}", text, why), parts_.clock.now().utc};
  }
  settled.put.push_back(std::move(entry));
  auto changing = change(std::move(settled));
  if (!co_await std::move(changing)) co_return;
  auto detail =
      fmt::format("{}: {}: {}", text, why,
                  sets_aside ? "it is set aside, the next one may start"
                             : "it is back in front and the queue is held until it is released");
  parts_.events.record_own(sets_aside ? "queue.set_aside" : "queue.failed", std::move(detail), run);
}

// From start to start: the first such instant that is still ahead.
void QueueDesk::add_repeat(const QueueEntry& entry, QueueChange& change) const {
  if (entry.repeat_every_s <= 0) return;
  const auto now = parts_.clock.now().utc;
  const auto every = nanoseconds_from_s(entry.repeat_every_s);
  const auto begun = entry.begun.utc_ns != 0 ? entry.begun : now;
  const auto periods = std::max<std::int64_t>(1, (now - begun) / every + 1);
  QueueEntry next = entry;
  next.id = next_id();
  next.place = last_place() + 1;
  next.state = QueueState::waiting;
  next.reason.clear();
  next.not_before = parts_.clock.utc(begun + every * periods);
  next.request_id.clear();
  next.created = now;
  next.run.reset();
  next.begun = next.ended = {};
  next.results.clear();
  change.put.push_back(std::move(next));
}

}  // namespace driftwise::application
