// Follow-ups of a run that is done: each is made once, and its result is stored until the store
// takes it.

#include <fmt/format.h>

#include "server/application/plumbing/run_on.h"
#include "server/application/queue/queue_desk.h"
#include "server/core/records/state_text.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr double kAskEvery_s = 5;  // of a diagnosis under way

}  // namespace

Awaitable<void> QueueDesk::follow(QueueEntryId id) {
  while (!ending_) {
    const auto* entry = find_entry(record_.entries, id);
    if (!entry || entry->state != QueueState::following) break;
    const auto position = static_cast<int>(entry->results.size());
    const auto kept = made_.find(id);
    if (kept == made_.end() || kept->second.result.position != position) {
      const QueueEntry copy = *entry;
      auto making = make(copy, position);
      auto made = co_await std::move(making);
      if (ending_) break;  // made again after the start
      made.result.position = position;
      made.result.at = parts_.clock.now().utc;
      made_[id] = std::move(made);
    }
    auto storing = store(id, made_.at(id));
    if (!co_await std::move(storing)) {  // tried again at the next look
      // A failure may be that of the store itself: it is made again. What is on record is not.
      const auto& result = made_.at(id).result;
      if (!result.good && !result.diagnosis) made_.erase(id);
      following_ = false;
      co_return;
    }
    made_.erase(id);
  }
  made_.erase(id);
  following_ = false;
  woken_ = true;
  wake_.raise();
}

// The result first, its alarm after it: one that the store refuses for an hour pages nobody twice.
Awaitable<Result<void>> QueueDesk::store(QueueEntryId id, Made made) {
  const auto lock = co_await changing_.lock();
  const auto* entry = find_entry(record_.entries, id);
  if (!entry) co_return Result<void>{};
  QueueEntry copy = *entry;
  copy.results.push_back(made.result);
  if (copy.results.size() >= copy.follow_ups.size()) copy.state = QueueState::done;
  const auto text = entry_text(copy);
  const auto run = copy.run;
  QueueChange following;
  following.put.push_back(std::move(copy));
  auto changing = change(std::move(following));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(changing));
  const auto& result = made.result;
  parts_.events.record_own(result.good ? "queue.followed" : "queue.follow_up_failed",
                           fmt::format("{}: {}", text, result.text), run);
  if (made.alarm) parts_.alarm(*std::move(made.alarm));
  if (!result.good)
    parts_.alarm({AlarmLevel::warning, "queue.follow_up_failed",
                  fmt::format("queue entry {}", id.value),
                  fmt::format("{}: {}; its run stays", text, result.text)});
  co_return Result<void>{};
}

Awaitable<QueueDesk::Made> QueueDesk::make(const QueueEntry& entry, int position) {
  const auto& wish = entry.follow_ups[static_cast<std::size_t>(position)];
  const auto what = parse_follow_up(wish);
  if (!what) co_return Made{QueueResult{.good = false, .text = what.error().message}, {}};
  if (what->kind == FollowUp::Kind::notify) {
    auto making = notice(entry);
    co_return co_await std::move(making);
  }
  auto making = what->kind == FollowUp::Kind::fit        ? fit(entry, what->formula)
                : what->kind == FollowUp::Kind::diagnose ? diagnose(entry, what->formula)
                                                         : report(entry);
  auto result = co_await std::move(making);
  co_return Made{std::move(result), {}};
}

Awaitable<QueueDesk::Made> QueueDesk::notice(const QueueEntry& entry) {
  auto looking = parts_.runs.get(*entry.run);
  const auto run = co_await std::move(looking);
  auto sentence = fmt::format("queue {} is done", entry_text(entry));
  if (run)
    sentence +=
        fmt::format(": {} of {} rows accepted in run {}", run->accepted, run->rows, run->id.value);
  for (const auto& result : entry.results) sentence += "; " + result.text;
  AlarmCondition done{AlarmLevel::notice, "queue.done",
                      fmt::format("queue entry {}", entry.id.value), std::move(sentence)};
  co_return Made{QueueResult{.text = "people were notified"}, std::move(done)};
}

Awaitable<QueueResult> QueueDesk::report(const QueueEntry& entry) {
  auto making = parts_.reports.page(*entry.run);
  auto page = co_await std::move(making);
  if (!page) co_return QueueResult{.good = false, .text = page.error().message};
  const auto path = report_path(parts_.description.database, entry.id, *entry.run);
  const auto written = co_await run_on(parts_.background, write_report, path, std::move(*page));
  if (!written) co_return QueueResult{.good = false, .text = written.error().message};
  co_return QueueResult{.text = fmt::format("the report {} was written ('driftwise queue report "
                                            "{}' makes it anew)",
                                            path, entry.id.value)};
}

Awaitable<QueueResult> QueueDesk::fit(const QueueEntry& entry, std::string formula) {
  FitRequest wanted;
  wanted.runs = {*entry.run};
  wanted.formula = std::move(formula);
  wanted.name = entry.name;
  wanted.note = fmt::format("made by queue {}", entry_text(entry));
  auto fitting = parts_.models.fit(in_the_name_of(entry), std::move(wanted));
  const auto model = co_await std::move(fitting);
  if (!model)
    co_return QueueResult{.good = false, .text = "the fit failed: " + model.error().message};
  co_return QueueResult{.text = fmt::format("model {} was fitted", model->id.value),
                        .model = model->id};
}

Awaitable<QueueResult> QueueDesk::diagnose(const QueueEntry& entry, std::string baseline) {
  DiagnosisRequest wanted;
  wanted.runs = {*entry.run};
  wanted.baseline = std::move(baseline);
  wanted.name = entry.name;
  auto creating = parts_.diagnoses.create(in_the_name_of(entry), std::move(wanted));
  auto found = co_await std::move(creating);
  std::optional<DiagnosisId> begun;
  if (found) begun = found->record.id;
  while (found && found->record.state == JobState::running && !ending_) {
    co_await sleep_unless(parts_.clock, parts_.clock.now().utc + nanoseconds_from_s(kAskEvery_s),
                          wake_);
    auto looking = parts_.diagnoses.get(*begun);
    found = co_await std::move(looking);
  }
  if (!found)
    co_return QueueResult{.good = false,
                          .text = "the diagnosis failed: " + found.error().message,
                          .diagnosis = begun};
  const auto id = found->record.id;
  if (found->record.state != JobState::done)
    co_return QueueResult{.good = false,
                          .text = fmt::format("diagnosis {} {}: {}", id.value,
                                              is_text(found->record.state), found->record.reason),
                          .diagnosis = id};
  co_return QueueResult{
      .text = fmt::format("diagnosis {} is done: {} findings", id.value,
                          found->found ? found->found->findings.size() : std::size_t{0}),
      .diagnosis = id};
}

}  // namespace driftwise::application
