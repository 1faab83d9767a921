#include "server/application/queue/queue_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

// Why the entry before it keeps this one waiting; empty: it was accepted.
std::string dependency_of(const std::vector<QueueEntry>& entries, QueueEntryId after) {
  const auto* before = find_entry(entries, after);
  if (!before)
    return fmt::format("waits for entry {}, which is not in the queue: change or remove this one",
                       after.value);
  const auto who = entry_text(*before);
  switch (before->state) {
    case QueueState::waiting:
      return fmt::format("waits until {} is accepted: that one waits", who);
    case QueueState::running:
      return fmt::format("waits until {} is accepted: that one is running", who);
    case QueueState::following:
      return fmt::format("waits until {} is accepted: what follows its run is being made", who);
    case QueueState::set_aside:
      return fmt::format(
          "waits for {}, which was set aside: move that one back, or change this one", who);
    case QueueState::removed:
      return fmt::format("waits for {}, which was removed: change or remove this one", who);
    case QueueState::done:
      break;
  }
  if (before->accepted()) return {};
  return fmt::format(
      "waits for {}, which was not accepted: something that followed its run failed: "
      "change or remove this one",
      who);
}

// Why this entry by itself is not ready; empty: it is.
std::string own_obstacle(const QueueSituation& situation, const QueueEntry& entry) {
  if (entry.not_before > situation.now)
    return fmt::format("waits until {}", to_iso8601(entry.not_before));
  if (entry.after)
    if (auto why = dependency_of(*situation.entries, *entry.after); !why.empty()) return why;
  if (entry.condition.empty()) return {};
  const auto verdict = situation.conditions.find(entry.id);
  if (verdict == situation.conditions.end())
    return fmt::format("waits for {}: not looked at yet", entry.condition);
  return verdict->second.met ? std::string() : "waits for " + verdict->second.sentence;
}

}  // namespace

std::vector<const QueueEntry*> waiting_in_order(const std::vector<QueueEntry>& entries) {
  std::vector<const QueueEntry*> waiting;
  for (const auto& entry : entries)
    if (entry.state == QueueState::waiting) waiting.push_back(&entry);
  std::ranges::sort(waiting, [](const QueueEntry* a, const QueueEntry* b) {
    if (a->priority != b->priority) return a->priority > b->priority;
    if (a->place != b->place) return a->place < b->place;
    return a->id < b->id;
  });
  return waiting;
}

const QueueEntry* find_entry(const std::vector<QueueEntry>& entries, QueueEntryId id) {
  const auto found = std::ranges::find(entries, id, &QueueEntry::id);
  return found == entries.end() ? nullptr : &*found;
}

std::string entry_text(const QueueEntry& entry) {
  return fmt::format("entry {} '{}'", entry.id.value, entry.name);
}

void forget_old_entries(std::vector<QueueEntry>& entries, int newest) {
  std::set<QueueEntryId> wanted;
  std::int64_t last = 0;
  for (const auto& entry : entries) {
    last = std::max(last, entry.id.value);
    if (!is_over(entry.state) && entry.after) wanted.insert(*entry.after);
  }
  std::erase_if(entries, [&](const QueueEntry& entry) {
    return is_over(entry.state) && entry.id.value <= last - newest && !wanted.contains(entry.id);
  });
}

std::vector<AlarmCondition> queue_alarms(const QueueRecord& record) {
  std::vector<AlarmCondition> alarms;
  const auto subject = [](const QueueEntry& entry) {
    return fmt::format("queue entry {}", entry.id.value);
  };
  const auto waiting = waiting_in_order(record.entries);
  if (record.hold.held)
    for (const auto* entry : waiting)
      if (!entry->reason.empty())
        alarms.push_back({AlarmLevel::warning, "queue.failed", subject(*entry),
                          fmt::format("{}: {}: it is back in front and the queue is held until it "
                                      "is released",
                                      entry_text(*entry), entry->reason)});
  const bool is_told = record.hold.who.empty() && !alarms.empty();  // the hold of that failure
  if (record.hold.held && !waiting.empty() && !is_told &&
      !record.hold.why.starts_with(kHeldByPerson))
    alarms.push_back({AlarmLevel::notice, "queue.held", "queue",
                      fmt::format("the queue is held: {}: {} of its campaigns wait until a person "
                                  "releases it ('driftwise queue release')",
                                  record.hold.why, waiting.size())});
  for (const auto& entry : record.entries)
    if (entry.state == QueueState::set_aside)
      alarms.push_back({AlarmLevel::warning, "queue.set_aside", subject(entry),
                        fmt::format("{}: {}: it is set aside, the next one may start until a "
                                    "person moves it back or removes it",
                                    entry_text(entry), entry.reason)});
  return alarms;
}

QueueTurn decide_turn(const QueueSituation& situation) {
  QueueTurn turn;
  std::string running;
  for (const auto& entry : *situation.entries)
    if (entry.state == QueueState::running)
      running = fmt::format("waits until {} is over", entry_text(entry));
  const QueueEntry* first = nullptr;
  for (const auto* entry : waiting_in_order(*situation.entries)) {
    if (auto why = own_obstacle(situation, *entry); !why.empty()) {
      turn.waits.emplace(entry->id, std::move(why));
    } else if (situation.hold.held) {
      turn.waits.emplace(
          entry->id,
          fmt::format("waits for a release of the queue, which is held: {}", situation.hold.why));
    } else if (!running.empty()) {
      turn.waits.emplace(entry->id, running);
    } else if (first) {
      turn.waits.emplace(entry->id, fmt::format("waits for its turn after {}", entry_text(*first)));
    } else {
      first = entry;
      if (situation.busy.empty())
        turn.starts = entry->id;
      else
        turn.waits.emplace(entry->id, "waits: " + situation.busy);
    }
  }
  return turn;
}

Result<void> check_dependency(const std::vector<QueueEntry>& entries, QueueEntryId id,
                              QueueEntryId after) {
  std::string chain = fmt::format("{}", id.value);
  for (std::optional<QueueEntryId> at = after; at;) {
    chain += fmt::format(" after {}", at->value);
    if (*at == id)
      return fail(ErrorCode::failed_precondition, reasons::kQueueCycle,
                  fmt::format("entry {} would wait for itself: {}", id.value, chain));
    const auto* entry = find_entry(entries, *at);
    if (!entry && *at == after)
      return fail(ErrorCode::not_found, reasons::kNoSuchQueueEntry,
                  fmt::format("after: there is no entry {} in the queue: 'driftwise queue list' "
                              "shows those there are",
                              after.value));
    at = entry ? entry->after : std::nullopt;
  }
  return {};
}

}  // namespace driftwise::application
