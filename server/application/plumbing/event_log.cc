#include "server/application/plumbing/event_log.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/core/ports/spawn.h"
#include "server/core/try.h"

namespace driftwise::application {

EventLog::EventLog(asio::any_io_executor executor, Clock& clock, StoreWriter& writer)
    : executor_(executor), clock_(clock), writer_(writer), drained_(executor), hurry_(executor) {}

void EventLog::record(const Caller& who, std::string what, std::string detail,
                      std::optional<RunId> run, ActChange change) {
  AuditRecord act;
  act.at = clock_.now();
  act.by = {who.name, who.proof.empty() ? "stated" : who.proof, who.peer};
  act.what = what;
  act.subject =
      change.subject.empty() && run ? fmt::format("run {}", run->value) : std::move(change.subject);
  act.before = std::move(change.before);
  act.after = std::move(change.after);
  act.outcome = std::move(change.outcome);
  push({{{}, act.at, who.name, who.peer, std::move(what), std::move(detail), run}, std::move(act)});
}

void EventLog::record_own(std::string what, std::string detail, std::optional<RunId> run) {
  push({{{}, clock_.now(), "daemon", "", std::move(what), std::move(detail), run}, {}});
}

void EventLog::push(Pending pending) {
  spdlog::info("{}: {} ({})", pending.event.what, pending.event.detail, pending.event.who);
  if (pending_.size() >= kMaxPending) return;
  pending_.push_back(std::move(pending));
  if (!pumping_) {
    pumping_ = true;
    spawn(executor_, pump());
  }
}

Awaitable<Result<EventId>> EventLog::store(const Pending& pending) {
  if (!pending.act) co_return co_await writer_.events().add_event(pending.event);
  DRIFTWISE_CO_TRY(const auto stored, co_await writer_.audit().add(*pending.act, pending.event));
  co_return stored.event;
}

Awaitable<void> EventLog::pump() {
  constexpr auto kRetry = std::chrono::seconds(5);
  while (!pending_.empty()) {
    const auto next = pending_.front();
    auto stored = co_await store(next);
    if (!stored && stored.error().code == ErrorCode::resource_exhausted && !shutting_down_) {
      co_await sleep_unless(clock_, clock_.now().utc + kRetry, hurry_);
      continue;
    }
    pending_.pop_front();
    auto event = next.event;
    if (stored)
      event.id = *stored;
    else
      spdlog::error("event {} not stored: {}", event.what, stored.error().message);
    watchers_.publish(event);
  }
  pumping_ = false;
  drained_.raise();
}

Awaitable<void> EventLog::written() {
  while (pumping_) co_await drained_.wait();
}

void EventLog::shut_down() {
  shutting_down_ = true;
  hurry_.raise();
}

}  // namespace driftwise::application
