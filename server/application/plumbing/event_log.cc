#include "server/application/plumbing/event_log.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/application/plumbing/store_refusal.h"
#include "server/core/ports/spawn.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

EventLog::EventLog(asio::any_io_executor executor, Clock& clock, StoreWriter& writer)
    : executor_(executor), clock_(clock), writer_(writer), drained_(executor), hurry_(executor) {}

EventLog::Pending EventLog::act_of(const Caller& who, std::string what, std::string detail,
                                   std::optional<RunId> run, ActChange change) const {
  AuditRecord act;
  act.at = clock_.now();
  act.by = {who.name, who.proof.empty() ? "stated" : who.proof, who.peer};
  act.what = what;
  act.subject =
      change.subject.empty() && run ? fmt::format("run {}", run->value) : std::move(change.subject);
  act.before = std::move(change.before);
  act.after = std::move(change.after);
  act.outcome = std::move(change.outcome);
  return {{{}, act.at, who.name, who.peer, std::move(what), std::move(detail), run},
          std::move(act),
          nullptr};
}

void EventLog::record(const Caller& who, std::string what, std::string detail,
                      std::optional<RunId> run, ActChange change) {
  push(act_of(who, std::move(what), std::move(detail), run, std::move(change)));
}

Awaitable<Result<void>> EventLog::record_first(Caller who, std::string what, std::string detail,
                                               std::optional<RunId> run, ActChange change) {
  auto ticket = std::make_shared<Ticket>(executor_);
  auto pending = act_of(who, std::move(what), std::move(detail), run, std::move(change));
  pending.ticket = ticket;
  push(std::move(pending));
  hurry_.raise();  // what waits for the database waits no longer than this person
  while (!ticket->result) co_await ticket->answered.wait();
  co_return *ticket->result;
}

void EventLog::record_own(std::string what, std::string detail, std::optional<RunId> run) {
  push({{{}, clock_.now(), "daemon", "", std::move(what), std::move(detail), run}, {}, nullptr});
}

void EventLog::push(Pending pending) {
  spdlog::info("{}: {} ({})", pending.event.what, pending.event.detail, pending.event.who);
  if (pending_.size() >= (pending.act ? kMaxActs : kMaxPending)) {
    lose(pending, "too many wait for the database");
    return;
  }
  pending_.push_back(std::move(pending));
  if (!pumping_) {
    pumping_ = true;
    spawn(executor_, pump());
  }
}

void EventLog::answer(const Pending& pending, Result<void> result) {
  if (!pending.ticket) return;
  pending.ticket->result = std::move(result);
  pending.ticket->answered.raise();
}

// Acts that wait for the record are told that the database takes nothing, and are not done.
void EventLog::refuse_who_waits(const Error& refusal) {
  for (const auto& pending : pending_) {
    if (!pending.ticket) continue;
    spdlog::warn("{} of {} was not done: {}", pending.event.what, pending.event.who,
                 refusal.message);
    answer(pending, tl::unexpected(refusal));
  }
  std::erase_if(pending_, [](const Pending& pending) { return pending.ticket != nullptr; });
}

// An act that was not done for want of a record is no loss: who asked for it was told.
void EventLog::lose(const Pending& pending, const std::string& why) {
  answer(pending, fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
                       "the act is not on record and was not done: " + why));
  if (!pending.act || pending.ticket) {
    spdlog::warn("event {} not stored: {}", pending.event.what, why);
    return;
  }
  ++lost_acts_;
  lost_because_ = why;
  spdlog::error("the act {} of {} is not on record: {}: {}", pending.event.what, pending.event.who,
                pending.event.detail, why);
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
    if (!stored && may_be_stored_later(stored.error()) && !shutting_down_) {
      refuse_who_waits(stored.error());
      if (!pending_.empty()) co_await sleep_unless(clock_, clock_.now().utc + kRetry, hurry_);
      continue;
    }
    pending_.pop_front();
    if (!stored && next.ticket) {
      answer(next, tl::unexpected(stored.error()));
      continue;
    }
    auto event = next.event;
    if (stored)
      event.id = *stored;
    else
      lose(next, stored.error().message);
    watchers_.publish(event);
    if (stored) answer(next, {});
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
