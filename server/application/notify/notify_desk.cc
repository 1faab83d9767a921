#include "server/application/notify/notify_desk.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

// Scheme, host and port: the path or query of a webhook is often its secret.
std::string way_of(const ReceiverDescription& receiver) {
  const auto host = receiver.webhook.find("://");
  if (host != std::string::npos)
    return "webhook " + receiver.webhook.substr(0, receiver.webhook.find_first_of("/?#", host + 3));
  if (!receiver.command.empty()) return "command " + receiver.command.front();
  return "mail by " + receiver.smtp;
}

Result<Delivery> call(Notifier* notifier, const ReceiverDescription& receiver,
                      const Notice& notice) {
  return notifier->tell(receiver, notice);
}

std::string remedy_of(const std::vector<AlarmNews>& news) {
  const auto open = std::ranges::find_if(news, [](const AlarmNews& one) {
    return one.alarm.id.value > 0 && one.alarm.acknowledged.utc_ns == 0;
  });
  if (open == news.end()) return {};
  return fmt::format(
      "driftwise alarms acknowledge {}   says that you have seen it: it is not repeated",
      open->alarm.id.value);
}

// Recipients who were refused, with the server's words; empty: none.
std::string refusals_of(const Result<Delivery>& said) {
  if (!said) return said.error().message;
  std::string text;
  for (const auto& one : said->refused)
    text += (text.empty() ? "" : "; ") + one.address + ": " + one.why;
  return text;
}

}  // namespace

NotifyDesk::NotifyDesk(asio::any_io_executor executor, Parts parts, Rules rules, LifeSigns::Run run)
    : executor_(executor),
      parts_(std::move(parts)),
      rules_(std::move(rules)),
      signs_(executor,
             {parts_.clock, parts_.reader, parts_.tasks, parts_.notifier, parts_.threads,
              parts_.unstored},
             {rules_.cell, rules_.version, rules_.watchdog}, std::move(run)),
      wake_(executor) {
  for (const auto& one : rules_.receivers) {
    receivers_.push_back(std::make_unique<Receiver>());
    receivers_.back()->description = one;
  }
}

void NotifyDesk::start() {
  if (parts_.notifier == nullptr) return;
  signs_.start();
  if (receivers_.empty()) return;
  watch_ = parts_.alarms.add([this](const AlarmRecord& alarm) { take(alarm); });
  parts_.tasks.spawn(begin());
}

void NotifyDesk::shut_down() {
  ending_ = true;
  watch_.reset();
  signs_.shut_down();
  if (parts_.notifier != nullptr) parts_.notifier->shut_down();
  wake_.raise();
}

void NotifyDesk::take(const AlarmRecord& alarm) {
  if (alarm.id.value == 0) return wake_.raise();  // not stored yet: take_unstored() has it
  if (finished_.contains(alarm.id.value)) return;
  auto& known = known_[alarm.id.value];
  if (known.alarm.change > alarm.change) return;
  known.alarm = alarm;
  // Messages sent before the store had room belong to the stored alarm.
  if (auto before = provisional_.extract({alarm.kind, alarm.subject, alarm.since.utc_ns})) {
    known.told = std::move(known_[before.mapped()].told);
    known_.erase(before.mapped());
    for (auto& [receiver, telling] : known.told) {
      telling.alarm = alarm.id;
      unstored_.push_back(telling);
    }
    parts_.tasks.spawn(keep({}));
  }
  wake_.raise();
}

void NotifyDesk::take_unstored() {
  if (!parts_.unstored) return;
  for (auto& alarm : parts_.unstored()) {
    const Occurrence occurrence{alarm.kind, alarm.subject, alarm.since.utc_ns};
    const auto next = -static_cast<std::int64_t>(provisional_.size()) - 1;
    const auto [entry, is_new] = provisional_.try_emplace(occurrence, next);
    while (is_new && known_.contains(entry->second)) --entry->second;
    alarm.id = {entry->second};
    known_[entry->second].alarm = std::move(alarm);
  }
}

// Every second of cell time, and at most twice a second of wall time: hours begin, repeats fall
// due.
Awaitable<void> NotifyDesk::pause() {
  const double seconds = std::max(1.0, 0.5 * parts_.clock.speed());
  co_await sleep_unless(parts_.clock, parts_.clock.now().utc + nanoseconds_from_s(seconds), wake_);
}

Awaitable<void> NotifyDesk::begin() {
  while (!ending_) {
    auto restoring = restore();
    if (co_await std::move(restoring)) break;
    auto pausing = pause();
    co_await std::move(pausing);
  }
  if (ending_) co_return;
  for (const auto& receiver : receivers_) parts_.tasks.spawn(serve(*receiver));
}

Awaitable<bool> NotifyDesk::restore() {
  std::vector<std::string> names;
  for (const auto& one : receivers_) names.push_back(one->description.name);
  const CellTime now = parts_.clock.now().utc;
  const auto open =
      co_await parts_.writer.outbox().open(names, now, now - nanoseconds_from_s(kForget_s));
  if (!open) {
    spdlog::warn("reading what receivers were told: {}", open.error().message);
    co_return false;
  }
  for (const auto& alarm : open->alarms) take(alarm);
  for (const auto& one : open->tellings) known_[one.alarm.value].told[one.receiver] = one;
  for (const auto& known : open->receivers)
    for (const auto& receiver : receivers_)
      if (receiver->description.name == known.name) receiver->known_since = known.known_since;
  co_return true;
}

NewsQuestion NotifyDesk::question(const Receiver& receiver, const Known& known) const {
  const auto told = known.told.find(receiver.description.name);
  const auto open = [&](CellTime at) {
    return in_hours(receiver.description, local_time(parts_.clock.utc(at)));
  };
  return {receiver.description,
          known.alarm,
          told == known.told.end() ? nullptr : &told->second,
          receiver.known_since,
          open(parts_.clock.now().utc),
          open(known.alarm.since),
          parts_.clock.now().utc};
}

// News that is due, and with it what begins within the same group.
Notice NotifyDesk::due_notice(Receiver& receiver) {
  const CellTime now = parts_.clock.now().utc;
  Notice notice{rules_.cell, rules_.web_address, parts_.clock.utc(now), {}, false};
  bool due = false;
  receiver.waiting = 0;
  take_unstored();
  for (const auto& [id, known] : known_) {
    const auto news = due_news(question(receiver, known));
    if (!news || (news->kind == NewsKind::repeat && news->at > now)) continue;
    ++receiver.waiting;
    due = due || news->at <= now;
    const AlarmRecord& alarm = known.alarm;
    if (notice.news.size() < Notice::kMost)
      notice.news.push_back(
          {alarm, news->kind, parts_.clock.utc(alarm.since),
           alarm.cleared.utc_ns == 0 ? UtcTime{} : parts_.clock.utc(alarm.cleared)});
  }
  if (!due) notice.news.clear();
  notice.remedy = remedy_of(notice.news);
  return notice;
}

Awaitable<void> NotifyDesk::serve(Receiver& receiver) {
  while (!ending_) {
    if (auto due = receiver.refused.due(parts_.clock.now().utc)) {
      auto telling = tell_again(receiver, *std::move(due));
      co_await std::move(telling);
      continue;
    }
    Notice notice = due_notice(receiver);
    if (notice.news.empty() || parts_.clock.now().utc < receiver.next_try) {
      if (known_.size() > kManyKnown) forget_what_is_over();
      auto pausing = pause();
      co_await std::move(pausing);
      continue;
    }
    auto telling = tell(receiver, std::move(notice));
    co_await std::move(telling);
    forget_what_is_over();
  }
}

TellingRecord* NotifyDesk::telling_of(const Receiver& receiver, const AlarmNews& news) {
  auto known = known_.find(news.alarm.id.value);
  if (known == known_.end())  // it was stored while the message was on its way
    known = std::ranges::find_if(known_, [&news](const auto& entry) {
      const AlarmRecord& one = entry.second.alarm;
      return one.kind == news.alarm.kind && one.subject == news.alarm.subject &&
             one.since == news.alarm.since;
    });
  if (known == known_.end()) return nullptr;
  auto& told = known->second.told[receiver.description.name];
  told.alarm = {known->first};
  told.receiver = receiver.description.name;
  return &told;
}

// The same mail for one recipient who was refused.
Awaitable<void> NotifyDesk::tell_again(Receiver& receiver, RefusedRecipients::Due due) {
  ReceiverDescription alone = receiver.description;
  alone.to = {due.address};
  const auto said = co_await run_on(parts_.threads, &call, parts_.notifier, alone, due.notice);
  if (!said && ending_) co_return;
  const CellTime now = parts_.clock.now().utc;
  receiver.refused.tried_again(due.address, said, now, 0.5 * parts_.clock.speed());
  receiver.answer = due.address + ": " + (said ? said->said : said.error().message);
  std::vector<TellingRecord> tellings;
  for (const auto& news : due.notice.news) {
    auto* told = telling_of(receiver, news);
    if (told == nullptr) continue;
    told->tried = now;
    told->failed = said ? 0 : told->failed + 1;
    told->error = said ? "" : receiver.answer;
    if (told->alarm.value > 0) tellings.push_back(*told);
  }
  auto keeping = keep(std::move(tellings));
  co_await std::move(keeping);
}

Awaitable<void> NotifyDesk::tell(Receiver& receiver, Notice notice) {
  const auto said =
      co_await run_on(parts_.threads, &call, parts_.notifier, receiver.description, notice);
  if (!said && ending_) co_return;
  const CellTime now = parts_.clock.now().utc;
  receiver.answer = said ? said->said : said.error().message;
  if (said) receiver.refused.take(notice, receiver.description.to, said->refused, now);
  std::vector<TellingRecord> tellings;
  for (const auto& news : notice.news) {
    auto* found = telling_of(receiver, news);
    if (found == nullptr) continue;
    auto& told = *found;
    told.tried = now;
    told.error = refusals_of(said);
    told.failed = told.error.empty() ? 0 : told.failed + 1;
    if (said) {
      ++told.count;
      if (news.kind == NewsKind::firing) told.firing = now;
      (news.kind == NewsKind::resolved ? told.resolved : told.last) = now;
    }
    if (told.alarm.value > 0) tellings.push_back(told);
  }
  if (said) {
    receiver.delivered = now;
    receiver.failing_since = {};
    receiver.retry_s = 0;
    receiver.next_try = {};
  } else {
    spdlog::warn("telling {} of {} alarms: {}", receiver.description.name, notice.news.size(),
                 said.error().message);
    if (receiver.failing_since.utc_ns == 0) receiver.failing_since = now;
    receiver.retry_s = std::clamp(2 * receiver.retry_s, kFirstRetry_s, kLongestRetry_s);
    const double wait_s = std::max(receiver.retry_s, 0.5 * parts_.clock.speed());
    receiver.next_try = now + nanoseconds_from_s(wait_s);
  }
  auto keeping = keep(std::move(tellings));
  co_await std::move(keeping);
}

// Tellings that a full disk refuses are kept in memory and written with the next one.
Awaitable<void> NotifyDesk::keep(std::vector<TellingRecord> tellings) {
  for (auto& one : tellings) {
    std::erase_if(unstored_, [&one](const TellingRecord& old) {
      return old.alarm == one.alarm && old.receiver == one.receiver;
    });
    unstored_.push_back(std::move(one));
  }
  std::vector<TellingRecord> storing = std::move(unstored_);
  unstored_.clear();
  const auto stored = co_await parts_.writer.outbox().put(storing);
  if (stored) co_return;
  spdlog::warn("what receivers were told is not stored: {}", stored.error().message);
  for (auto& one : storing)
    if (std::ranges::none_of(unstored_, [&one](const TellingRecord& newer) {
          return newer.alarm == one.alarm && newer.receiver == one.receiver;
        }))
      unstored_.push_back(std::move(one));
}

void NotifyDesk::forget_what_is_over() {
  std::erase_if(known_, [&](const auto& entry) {
    const Known& known = entry.second;
    if (entry.first < 0 || known.alarm.cleared.utc_ns == 0)
      return false;  // below 0: not stored yet
    const bool over = std::ranges::all_of(
        receivers_, [&](const auto& receiver) { return is_finished(question(*receiver, known)); });
    if (over) finished_.insert(entry.first);
    return over;
  });
}

std::vector<ReceiverStatus> NotifyDesk::receivers() const {
  std::vector<ReceiverStatus> out;
  for (const auto& one : receivers_)
    out.push_back({one->description.name, way_of(one->description), one->waiting, one->delivered,
                   one->failing_since, one->answer});
  if (auto watchdog = signs_.status()) out.push_back(std::move(*watchdog));
  return out;
}

Awaitable<Result<std::vector<TellingRecord>>> NotifyDesk::tellings(int limit) {
  return parts_.reader.outbox().tellings(limit);
}

Awaitable<Result<std::string>> NotifyDesk::test(Caller caller, std::string name) {
  const auto found = std::ranges::find_if(
      receivers_, [&name](const auto& one) { return one->description.name == name; });
  if (found == receivers_.end() || parts_.notifier == nullptr) {
    std::string known;
    for (const auto& one : receivers_) known += (known.empty() ? "" : ", ") + one->description.name;
    co_return fail(ErrorCode::not_found, reasons::kNoSuchReceiver,
                   fmt::format("there is no receiver '{}': the cell file has {}", name,
                               known.empty() ? "no [[notify]]" : known));
  }
  Receiver& receiver = **found;
  const Notice notice{
      rules_.cell, rules_.web_address, parts_.clock.utc(parts_.clock.now().utc), {}, true};
  const auto said =
      co_await run_on(parts_.threads, &call, parts_.notifier, receiver.description, notice);
  receiver.answer = said ? said->said : said.error().message;
  if (said)
    receiver.refused.take(notice, receiver.description.to, said->refused, parts_.clock.now().utc);
  if (said) {  // the way is open: what waits goes now
    receiver.delivered = parts_.clock.now().utc;
    receiver.failing_since = {};
    receiver.next_try = {};
    receiver.retry_s = 0;
    wake_.raise();
  }
  parts_.events.record(caller, "notify.tested", fmt::format("{}: {}", name, receiver.answer), {},
                       {"receiver " + name, "", said ? "arrived" : "failed"});
  DRIFTWISE_CO_RETURN_IF_ERROR(said);
  co_return said->said;
}

bool NotifyDesk::has_judged(const std::string& kind, const std::string& subject) const {
  if (kind == "watchdog.unreached") return signs_.has_judged();
  for (const auto& one : receivers_) {
    const auto& description = one->description;
    if (subject == description.name) return one->delivered.utc_ns != 0;
    for (const auto& address : description.to)
      if (subject == description.name + " " + address) return one->refused.has_reached(address);
  }
  return true;
}

std::vector<AlarmCondition> NotifyDesk::conditions() const {
  std::vector<AlarmCondition> out;
  const CellTime now = parts_.clock.now().utc;
  const double patience_s = kFailing_s * std::max(1.0, parts_.clock.speed());
  for (const auto& one : receivers_) {
    if (one->failing_since.utc_ns == 0) continue;
    if (seconds_from(now - one->failing_since) < patience_s) continue;
    out.push_back({AlarmLevel::warning, "notify.failed", one->description.name,
                   fmt::format("{} ({}) has taken no message since {}: {}; it is tried again every "
                               "5 min, 'driftwise notify test {}' tries now",
                               one->description.name, way_of(one->description),
                               to_iso8601(parts_.clock.utc(one->failing_since)), one->answer,
                               one->description.name)});
  }
  for (const auto& receiver : receivers_)
    for (const auto& one : receiver->refused.failing(now, patience_s)) {
      const auto& name = receiver->description.name;
      out.push_back(
          {AlarmLevel::warning, "notify.failed", name + " " + one.address,
           fmt::format("{} ({}) does not reach {} since {}: {}; {}", name,
                       way_of(receiver->description), one.address,
                       to_iso8601(parts_.clock.utc(one.since)), one.why,
                       one.for_now ? "it is tried again every 5 min"
                                   : "correct `to` of its [[notify]], or the mailbox, then "
                                     "'driftwise notify test " +
                                         name + "'")});
    }
  if (auto silent = signs_.condition()) out.push_back(std::move(*silent));
  return out;
}

}  // namespace driftwise::application
