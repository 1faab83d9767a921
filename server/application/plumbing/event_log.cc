#include "server/application/plumbing/event_log.h"

#include <spdlog/spdlog.h>

#include "server/core/ports/spawn.h"

namespace driftwise::application {

EventLog::EventLog(asio::any_io_executor executor, Clock& clock, StoreWriter& writer)
    : executor_(executor), clock_(clock), writer_(writer), drained_(executor), hurry_(executor) {}

void EventLog::record(const Caller& who, std::string what, std::string detail,
                      std::optional<RunId> run) {
  push({{}, clock_.now(), who.name, who.peer, std::move(what), std::move(detail), run});
}

void EventLog::record_own(std::string what, std::string detail, std::optional<RunId> run) {
  push({{}, clock_.now(), "daemon", "", std::move(what), std::move(detail), run});
}

void EventLog::push(EventRecord event) {
  spdlog::info("{}: {} ({})", event.what, event.detail, event.who);
  if (pending_.size() >= kMaxPending) return;
  pending_.push_back(std::move(event));
  if (!pumping_) {
    pumping_ = true;
    spawn(executor_, pump());
  }
}

Awaitable<void> EventLog::pump() {
  constexpr auto kRetry = std::chrono::seconds(5);
  while (!pending_.empty()) {
    auto event = pending_.front();
    auto stored = co_await writer_.events().add_event(event);
    if (!stored && stored.error().code == ErrorCode::resource_exhausted && !shutting_down_) {
      co_await sleep_unless(clock_, clock_.now().utc + kRetry, hurry_);
      continue;
    }
    pending_.pop_front();
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
