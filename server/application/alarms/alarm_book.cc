#include "server/application/alarms/alarm_book.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/core/try.h"

namespace driftwise::application {

Awaitable<Result<void>> AlarmBook::restore() {
  constexpr int kAll = 0;  // however many nobody has acknowledged
  DRIFTWISE_CO_TRY(const auto alarms, co_await writer_.alarms().alarms(false, kAll));
  for (const auto& alarm : alarms)
    if (alarm.cleared.utc_ns == 0)
      standing_[{alarm.kind, alarm.subject}] = {
          alarm.id, 0, alarm.message, alarm.consequences, clock_.now().utc, alarm};
  co_return Result<void>{};
}

std::vector<AlarmRecord> AlarmBook::unjudged() const {
  std::vector<AlarmRecord> out;
  for (const auto& [key, standing] : standing_)
    if (standing.restored) out.push_back(*standing.restored);
  return out;
}

Awaitable<void> AlarmBook::look(std::vector<AlarmCondition> conditions, IsJudged is_judged) {
  std::set<Key> found;
  for (const auto& condition : conditions) {
    Key key{condition.kind, condition.subject};
    if (const auto known = standing_.find(key); known != standing_.end()) {
      known->second.looks_without = 0;
      if (!condition.settling) known->second.restored.reset();
    } else if (const auto waiting = unstored_.find(key); waiting != unstored_.end()) {
      waiting->second.looks_without = 0;
      waiting->second.alarm.cleared = {};
    } else if (!condition.settling) {
      unstored_.emplace(key, Unstored{begun(condition)});
    }
    found.insert(std::move(key));
  }
  auto storing = store_what_waits(found);
  co_await std::move(storing);
  auto telling = tell_what_changed(conditions);
  co_await std::move(telling);
  std::vector<Key> over;
  for (auto& [key, standing] : standing_) {
    if (found.contains(key)) continue;
    if (standing.restored && is_judged && !is_judged(*standing.restored)) continue;
    standing.restored.reset();
    if (++standing.looks_without >= kLooksToClear) over.push_back(key);
  }
  for (const Key& key : over) {
    const AlarmId id = standing_[key].id;
    const CellTime now = clock_.now().utc;
    const auto cleared = co_await writer_.alarms().clear(id, now);
    if (!cleared) continue;
    standing_.erase(key);
    watchers_.publish(*cleared);
  }
}

Awaitable<void> AlarmBook::tell_what_changed(const std::vector<AlarmCondition>& conditions) {
  for (const auto& condition : conditions) {
    const Key key{condition.kind, condition.subject};
    const auto known = standing_.find(key);
    if (known == standing_.end()) {
      // One that waits for room in the record says what holds now.
      if (const auto waits = unstored_.find(key); waits != unstored_.end())
        waits->second.alarm.message = condition.message;
      continue;
    }
    const auto& told = known->second;
    const bool more = condition.consequences.size() != told.consequences.size();
    const bool other =
        condition.message != told.message || condition.consequences != told.consequences;
    if (!other || (!more && clock_.now().utc - told.told < kBetweenTellings)) continue;
    const auto stored =
        co_await writer_.alarms().tell(told.id, condition.message, condition.consequences);
    if (!stored) co_return;
    standing_[key] = {.id = stored->id,
                      .message = condition.message,
                      .consequences = condition.consequences,
                      .told = clock_.now().utc,
                      .restored = std::move(standing_[key].restored)};
    watchers_.publish(*stored);
  }
}

Awaitable<void> AlarmBook::store_what_waits(const std::set<Key>& found) {
  std::vector<Key> waiting;
  for (auto& [key, one] : unstored_) {
    if (!found.contains(key) && one.alarm.cleared.utc_ns == 0 &&
        ++one.looks_without >= kLooksToClear)
      one.alarm.cleared = clock_.now().utc;
    waiting.push_back(key);
  }
  for (const Key& key : waiting) {
    auto storing = store(unstored_.at(key).alarm);
    const auto stored = co_await std::move(storing);
    if (!stored) co_return;  // no room yet
    const auto one = unstored_.extract(key).mapped();
    if (one.alarm.cleared.utc_ns == 0)
      standing_[key] = {.id = stored->id,
                        .looks_without = std::max(0, one.looks_without - 1),  // look() counts it
                        .message = stored->message,
                        .consequences = stored->consequences,
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
  if (unstored_notes_.size() < kMostNotes)
    unstored_notes_.push_back(std::move(alarm));
  else
    spdlog::error("alarm {} is not on record: {}: {}", alarm.kind, alarm.message,
                  stored.error().message);
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

Awaitable<Result<AlarmRecord>> AlarmBook::acknowledge(AlarmId id, std::string who) {
  const CellTime now = clock_.now().utc;
  auto stored = co_await writer_.alarms().acknowledge(id, now, who);
  if (stored) watchers_.publish(*stored);
  co_return stored;
}

Awaitable<Result<AlarmRecord>> AlarmBook::shelve(AlarmId id, double for_s, std::string who,
                                                 std::string reason) {
  const CellTime now = clock_.now().utc;
  AlarmShelf shelf{now, now + nanoseconds_from_s(for_s), std::move(who), std::move(reason)};
  auto stored = co_await writer_.alarms().shelve(id, std::move(shelf));
  if (stored) watchers_.publish(*stored);
  co_return stored;
}

Awaitable<Result<AlarmRecord>> AlarmBook::unshelve(AlarmId id) {
  const CellTime now = clock_.now().utc;
  auto stored = co_await writer_.alarms().unshelve(id, now);
  if (stored) watchers_.publish(*stored);
  co_return stored;
}

Awaitable<void> AlarmBook::end_shelves() {
  const CellTime now = clock_.now().utc;
  if (next_shelf_look_ > now) co_return;
  next_shelf_look_ = now + kBetweenTellings;
  const auto back = co_await writer_.alarms().end_shelves(now);
  if (!back) co_return;
  for (const auto& alarm : *back) watchers_.publish(alarm);
}

}  // namespace driftwise::application
