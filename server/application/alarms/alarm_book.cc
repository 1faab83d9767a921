#include "server/application/alarms/alarm_book.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/core/try.h"

namespace driftwise::application {

Awaitable<Result<void>> AlarmBook::restore() {
  constexpr int kAll = 0;  // however many nobody has acknowledged
  DRIFTWISE_CO_TRY(const auto alarms, co_await writer_.alarms().alarms(false, kAll));
  for (const auto& alarm : alarms)
    if (alarm.cleared.utc_ns == 0)
      standing_[{alarm.kind, alarm.subject}] = {
          .alarm = alarm, .told = clock_.now().utc, .restored = true};
  co_return Result<void>{};
}

std::vector<AlarmRecord> AlarmBook::unjudged() const {
  std::vector<AlarmRecord> out;
  for (const auto& [key, standing] : standing_)
    if (standing.restored) out.push_back(standing.alarm);
  return out;
}

Awaitable<void> AlarmBook::look(std::vector<AlarmCondition> conditions, IsJudged is_judged) {
  std::set<Key> found;
  for (const auto& condition : conditions) {
    Key key{condition.kind, condition.subject};
    if (const auto known = standing_.find(key); known != standing_.end()) {
      known->second.looks_without = 0;
      if (!condition.settling) known->second.restored = false;
    } else if (const auto waiting = unstored_.find(key);
               waiting != unstored_.end() && waiting->second.alarm.cleared.utc_ns == 0) {
      waiting->second.looks_without = 0;
    } else if (!condition.settling) {
      if (waiting != unstored_.end()) keep(std::move(waiting->second.alarm));  // its end was told
      unstored_[key] = {.alarm = begun(condition), .told = clock_.now().utc};
    }
    found.insert(std::move(key));
  }
  auto storing = store_what_waits(found);
  co_await std::move(storing);
  auto telling = tell_what_changed(conditions);
  co_await std::move(telling);
  publish_unstored();
  std::vector<Key> over;
  for (auto& [key, standing] : standing_) {
    if (found.contains(key)) continue;
    if (standing.restored && is_judged && !is_judged(standing.alarm)) continue;
    standing.restored = false;
    if (++standing.looks_without >= kLooksToClear) over.push_back(key);
  }
  std::vector<AlarmId> ended;
  for (const Key& key : over) {
    AlarmRecord alarm = std::move(standing_.extract(key).mapped().alarm);
    alarm.cleared = clock_.now().utc;
    ended.push_back(alarm.id);
    ended_[alarm.id] = std::move(alarm);
  }
  auto ending = store_ends();
  co_await std::move(ending);
  for (const AlarmId id : ended)
    if (const auto kept = ended_.find(id); kept != ended_.end()) {
      const AlarmRecord alarm = kept->second;
      watchers_.publish(alarm);
    }
}

Awaitable<void> AlarmBook::tell_what_changed(const std::vector<AlarmCondition>& conditions) {
  for (const auto& condition : conditions) {
    const Key key{condition.kind, condition.subject};
    const auto known = standing_.find(key);
    const auto waits = unstored_.find(key);
    if (known == standing_.end() && waits == unstored_.end()) continue;
    AlarmRecord& alarm = known == standing_.end() ? waits->second.alarm : known->second.alarm;
    CellTime& told = known == standing_.end() ? waits->second.told : known->second.told;
    const bool more = condition.consequences.size() != alarm.consequences.size();
    const bool other =
        condition.message != alarm.message || condition.consequences != alarm.consequences;
    const bool is_news = other && (more || clock_.now().utc - told >= kBetweenTellings);
    if (is_news) {
      alarm.message = condition.message;
      alarm.consequences = condition.consequences;
      told = clock_.now().utc;
    }
    if (known == standing_.end()) {
      waits->second.is_news = waits->second.is_news || is_news;
      continue;
    }
    if (!is_news && !known->second.unstored) continue;
    const AlarmRecord now = alarm;
    const auto stored = co_await writer_.alarms().tell(now.id, now.message, now.consequences);
    Standing& standing = standing_.at(key);
    standing.unstored = !stored;
    if (stored) {
      publish(*stored);
    } else if (is_news) {
      const AlarmRecord present = standing.alarm;
      watchers_.publish(present);
    }
  }
}

Awaitable<void> AlarmBook::store_ends() {
  std::vector<AlarmRecord> ends;
  for (const auto& [id, alarm] : ended_) ends.push_back(alarm);
  for (const auto& alarm : ends) {
    const auto cleared = co_await writer_.alarms().clear(alarm.id, alarm.cleared);
    if (!cleared) continue;
    ended_.erase(alarm.id);
    watchers_.publish(*cleared);
  }
}

void AlarmBook::publish_unstored() {
  std::vector<AlarmRecord> news;
  for (auto& [key, one] : unstored_)
    if (std::exchange(one.is_news, false)) news.push_back(one.alarm);
  for (const auto& alarm : news) watchers_.publish(alarm);
}

// A changed record for the watchers, with the message and the end that the store does not have yet.
AlarmRecord AlarmBook::publish(AlarmRecord stored) {
  if (const auto ended = ended_.find(stored.id); ended != ended_.end()) {
    stored.cleared = ended->second.cleared;
    ended->second = stored;
  }
  if (const auto known = standing_.find({stored.kind, stored.subject});
      known != standing_.end() && known->second.alarm.id == stored.id) {
    if (known->second.unstored) {
      stored.message = known->second.alarm.message;
      stored.consequences = known->second.alarm.consequences;
    }
    known->second.alarm = stored;
  }
  watchers_.publish(stored);
  return stored;
}

Awaitable<void> AlarmBook::store_what_waits(const std::set<Key>& found) {
  std::vector<Key> waiting;
  for (auto& [key, one] : unstored_) {
    if (!found.contains(key) && one.alarm.cleared.utc_ns == 0 &&
        ++one.looks_without >= kLooksToClear) {
      one.alarm.cleared = clock_.now().utc;
      one.is_news = true;
    }
    waiting.push_back(key);
  }
  for (const Key& key : waiting) {
    auto storing = store(unstored_.at(key).alarm);
    const auto stored = co_await std::move(storing);
    if (!stored) co_return;  // no room yet
    const auto one = unstored_.extract(key).mapped();
    if (one.alarm.cleared.utc_ns == 0)
      standing_[key] = {.alarm = *stored,
                        .looks_without = std::max(0, one.looks_without - 1),  // look() counts it
                        .told = clock_.now().utc};
  }
  while (!unstored_notes_.empty()) {
    const auto oldest = unstored_notes_.front();
    auto storing = store(oldest);
    if (const auto stored = co_await std::move(storing); !stored) co_return;
    unstored_notes_.pop_front();
  }
}

Awaitable<void> AlarmBook::note(AlarmCondition condition) {
  AlarmRecord alarm = begun(condition);
  alarm.cleared = alarm.since;
  auto storing = store(alarm);
  const auto stored = co_await std::move(storing);
  if (stored) co_return;
  if (keep(alarm)) watchers_.publish(alarm);
}

bool AlarmBook::keep(AlarmRecord over) {
  const bool has_room = unstored_notes_.size() < kMostNotes;
  if (has_room)
    unstored_notes_.push_back(std::move(over));
  else
    spdlog::error("alarm {} is not on record, which takes nothing: {}", over.kind, over.message);
  return has_room;
}

AlarmRecord AlarmBook::begun(const AlarmCondition& condition) const {
  AlarmRecord alarm;
  alarm.level = condition.level;
  alarm.kind = condition.kind;
  alarm.subject = condition.subject;
  alarm.message = condition.message;
  alarm.consequences = condition.consequences;
  alarm.since = clock_.now().utc;
  spdlog::warn("alarm {}: {}", alarm.kind, alarm.message);
  return alarm;
}

Awaitable<Result<AlarmRecord>> AlarmBook::store(AlarmRecord alarm) {
  auto stored = co_await writer_.alarms().raise(alarm);
  if (stored) watchers_.publish(*stored);
  co_return stored;
}

std::vector<AlarmRecord> AlarmBook::unstored() const {
  std::vector<AlarmRecord> out;
  for (const auto& [key, one] : unstored_) out.push_back(one.alarm);
  out.insert(out.end(), unstored_notes_.begin(), unstored_notes_.end());
  std::ranges::stable_sort(out, {}, [](const AlarmRecord& alarm) { return alarm.since.utc_ns; });
  return out;
}

std::vector<AlarmRecord> AlarmBook::outdated() const {
  std::vector<AlarmRecord> out;
  for (const auto& [key, one] : standing_)
    if (one.unstored) out.push_back(one.alarm);
  for (const auto& [id, alarm] : ended_) out.push_back(alarm);
  return out;
}

Awaitable<Result<AlarmRecord>> AlarmBook::acknowledge(AlarmId id, std::string who) {
  const CellTime now = clock_.now().utc;
  auto stored = co_await writer_.alarms().acknowledge(id, now, who);
  if (stored) *stored = publish(*stored);
  co_return stored;
}

Awaitable<Result<AlarmRecord>> AlarmBook::shelve(AlarmId id, double for_s, std::string who,
                                                 std::string reason) {
  const CellTime now = clock_.now().utc;
  AlarmShelf shelf{now, now + nanoseconds_from_s(for_s), std::move(who), std::move(reason)};
  auto stored = co_await writer_.alarms().shelve(id, std::move(shelf));
  if (stored) *stored = publish(*stored);
  co_return stored;
}

Awaitable<Result<AlarmRecord>> AlarmBook::unshelve(AlarmId id) {
  const CellTime now = clock_.now().utc;
  auto stored = co_await writer_.alarms().unshelve(id, now);
  if (stored) *stored = publish(*stored);
  co_return stored;
}

Awaitable<void> AlarmBook::end_shelves() {
  const CellTime now = clock_.now().utc;
  if (next_shelf_look_ > now) co_return;
  next_shelf_look_ = now + kBetweenTellings;
  const auto back = co_await writer_.alarms().end_shelves(now);
  if (!back) co_return;
  for (const auto& alarm : *back) publish(alarm);
}

}  // namespace driftwise::application
