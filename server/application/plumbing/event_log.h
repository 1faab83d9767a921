#pragma once
// What happened, by whose hand: written in order, told to watchers once it is on disk.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/watch_list.h"
#include "server/application/ports/caller.h"
#include "server/core/ports/clock.h"
#include "server/core/records/records.h"

namespace driftwise::application {

// What an act of a person changed, for the audit.
struct ActChange {
  std::string subject;        // "model 3"; empty: the run, where there is one
  std::string before, after;  // empty: none
  std::string outcome = {};   // empty: done; else why it was refused
};

class EventLog {
 public:
  // While the database takes nothing: own events beyond it are only logged, the newest first.
  static constexpr std::size_t kMaxPending = 10'000;
  // Acts of people are kept beyond that: lost above this number alone, which raises an alarm.
  static constexpr std::size_t kMaxActs = 100'000;

  EventLog(asio::any_io_executor executor, Clock& clock, StoreWriter& writer);

  // Returns at once; the event is written by the log's own coroutine, and with it, in one
  // transaction, the act in the audit. what: dotted and stable; detail: a sentence.
  void record(const Caller& who, std::string what, std::string detail,
              std::optional<RunId> run = {}, ActChange change = {});
  // For an act that changes what protects people and machine, or that moves the robot: on the disk
  // when it returns, to be done after that. Errors: those of the store; then nothing is on record
  // and the act is not to be done.
  Awaitable<Result<void>> record_first(Caller who, std::string what, std::string detail,
                                       std::optional<RunId> run = {}, ActChange change = {});
  void record_own(std::string what, std::string detail,
                  std::optional<RunId> run = {});  // by the daemon itself

  Awaitable<void> written();  // everything recorded so far is on disk, or the disk refuses it and
                              // we are shutting down
  void shut_down();           // no more waiting for a full disk

  // Acts of people that are done and will never be on record, since the start; 0: none.
  std::int64_t lost_acts() const { return lost_acts_; }
  const std::string& lost_because() const { return lost_because_; }  // of the newest of them

  WatchList<EventRecord>& watchers() { return watchers_; }

 private:
  struct Ticket {  // of somebody who waits for the record
    explicit Ticket(const asio::any_io_executor& executor) : answered(executor) {}
    Signal answered;
    std::optional<Result<void>> result;
  };
  struct Pending {
    EventRecord event;
    std::optional<AuditRecord> act;  // of a person
    std::shared_ptr<Ticket> ticket;  // nullptr: nobody waits
  };
  Pending act_of(const Caller& who, std::string what, std::string detail, std::optional<RunId> run,
                 ActChange change) const;
  void answer(const Pending& pending, Result<void> result);
  void refuse_who_waits(const Error& refusal);
  void lose(const Pending& pending, const std::string& why);
  void push(Pending pending);
  Awaitable<Result<EventId>> store(const Pending& pending);
  Awaitable<void> pump();

  asio::any_io_executor executor_;
  Clock& clock_;
  StoreWriter& writer_;
  WatchList<EventRecord> watchers_;
  std::deque<Pending> pending_;
  bool pumping_ = false, shutting_down_ = false;
  std::int64_t lost_acts_ = 0;
  std::string lost_because_;
  Signal drained_, hurry_;
};

}  // namespace driftwise::application
