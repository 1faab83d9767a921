#include "server/application/alarm_book.h"

#include <spdlog/spdlog.h>

#include <set>

namespace driftwise::application {

Awaitable<Result<void>> AlarmBook::restore() {
  constexpr int kMost = 10'000;
  auto asking = writer_.call([](Store& store) { return store.alarms().alarms(false, kMost); });
  const auto alarms = co_await std::move(asking);
  if (!alarms) co_return tl::unexpected(alarms.error());
  for (const auto& alarm : *alarms)
    if (alarm.cleared.utc_ns == 0) standing_[{alarm.kind, alarm.subject}] = {alarm.id, 0};
  co_return Result<void>{};
}

Awaitable<void> AlarmBook::look(std::vector<AlarmCondition> conditions) {
  std::set<Key> found;
  for (auto& condition : conditions) {
    const Key key{condition.kind, condition.subject};
    found.insert(key);
    if (const auto known = standing_.find(key); known != standing_.end()) {
      known->second.looks_without = 0;
      continue;
    }
    auto raising = raise(condition, false);
    const auto raised = co_await std::move(raising);
    if (raised) standing_[key] = {raised->id, 0};
  }
  std::vector<Key> over;
  for (auto& [key, standing] : standing_)
    if (!found.contains(key) && ++standing.looks_without >= kLooksToClear) over.push_back(key);
  for (const Key& key : over) {
    const AlarmId id = standing_[key].id;
    const CellTime now = clock_.now().utc;
    auto clearing = writer_.call([id, now](Store& store) { return store.alarms().clear(id, now); });
    const auto cleared = co_await std::move(clearing);
    if (!cleared) continue;
    standing_.erase(key);
    watchers_.publish(*cleared);
  }
}

Awaitable<void> AlarmBook::note(AlarmCondition condition) {
  auto raising = raise(std::move(condition), true);
  co_await std::move(raising);
}

Awaitable<Result<AlarmRecord>> AlarmBook::raise(AlarmCondition condition, bool over) {
  AlarmRecord alarm;
  alarm.level = condition.level;
  alarm.kind = condition.kind;
  alarm.subject = condition.subject;
  alarm.message = condition.message;
  alarm.since = clock_.now().utc;
  if (over) alarm.cleared = alarm.since;
  auto storing = writer_.call([alarm](Store& store) { return store.alarms().raise(alarm); });
  auto stored = co_await std::move(storing);
  if (stored) {
    spdlog::warn("alarm {}: {}", stored->kind, stored->message);
    watchers_.publish(*stored);
  }
  co_return stored;
}

Awaitable<Result<AlarmRecord>> AlarmBook::acknowledge(AlarmId id, std::string who) {
  const CellTime now = clock_.now().utc;
  auto storing = writer_.call(
      [id, now, who](Store& store) { return store.alarms().acknowledge(id, now, who); });
  auto stored = co_await std::move(storing);
  if (stored) watchers_.publish(*stored);
  co_return stored;
}

}  // namespace driftwise::application
