#pragma once
// What happened, by whose hand: written in order, told to watchers once it is on disk.

#include <deque>
#include <optional>
#include <string>

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
  static constexpr std::size_t kMaxPending =
      10'000;  // while the disk is full; the newest beyond it are only logged

  EventLog(asio::any_io_executor executor, Clock& clock, StoreWriter& writer);

  // Returns at once; the event is written by the log's own coroutine, and with it, in one
  // transaction, the act in the audit. what: dotted and stable; detail: a sentence.
  void record(const Caller& who, std::string what, std::string detail,
              std::optional<RunId> run = {}, ActChange change = {});
  void record_own(std::string what, std::string detail,
                  std::optional<RunId> run = {});  // by the daemon itself

  Awaitable<void> written();  // everything recorded so far is on disk, or the disk refuses it and
                              // we are shutting down
  void shut_down();           // no more waiting for a full disk

  WatchList<EventRecord>& watchers() { return watchers_; }

 private:
  struct Pending {
    EventRecord event;
    std::optional<AuditRecord> act;  // of a person
  };
  void push(Pending pending);
  Awaitable<Result<EventId>> store(const Pending& pending);
  Awaitable<void> pump();

  asio::any_io_executor executor_;
  Clock& clock_;
  StoreWriter& writer_;
  WatchList<EventRecord> watchers_;
  std::deque<Pending> pending_;
  bool pumping_ = false, shutting_down_ = false;
  Signal drained_, hurry_;
};

}  // namespace driftwise::application
