#pragma once
// The queue at work: holds its state, starts the entry whose turn it is, settles the one whose run
// is over, makes what follows. Executor's thread.
//
// Every change is on the disk before it is in memory. An entry becomes running in the transaction
// that creates its run; one whose run is over is settled in one more. So after a kill at any place
// the entry is found waiting, or running with a run that continues or is over.

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "server/application/diagnoses/diagnoses.h"
#include "server/application/models/models.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/application/queue/follow_up.h"
#include "server/application/queue/queue_outlook.h"
#include "server/application/queue/queue_rule.h"
#include "server/application/recording/recorder.h"
#include "server/application/report/reports.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/runs.h"
#include "server/application/trajectories/duration_book.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class QueueDesk {
 public:
  // Entries that are over and stay in lists.
  static constexpr int kHistory = 200;

  struct Parts {  // all of them outlive this
    const CellDescription& description;
    Clock& clock;
    const Recorder& recorder;
    StoreReader& reader;
    StoreWriter& writer;
    EventLog& events;
    Runs& runs;
    const RunEngine& engine;
    const RightToMove& right;
    const StopDesk& stops;
    const DurationBook& durations;
    LeaseBook& leases;
    Models& models;
    Diagnoses& diagnoses;
    Reports& reports;
    TaskGroup& tasks;
    asio::any_io_executor background;  // where reports are written
    std::function<bool()> improving;   // an improvement is under way: it moves the robot again
    std::function<void(AlarmCondition)> alarm;  // of what is over at once
  };
  QueueDesk(asio::any_io_executor executor, Parts parts);

  void restore(QueueRecord record) { record_ = std::move(record); }  // before start()
  void start();  // once, when a run that was under way goes on
  void shut_down();

  // Every stop and every abort by a person: the store holds the queue with the stop itself.
  void stopped(const Caller& caller, const std::string& cause);

  // One at a time changes the queue.
  Awaitable<AsyncMutex::Lock> turn() { return changing_.lock(); }
  // On the disk, then here. Only by who has the turn.
  Awaitable<Result<void>> change(QueueChange change);
  // A person has just said that entries may start.
  void look_now();

  const std::vector<QueueEntry>& entries() const { return record_.entries; }
  const QueueHold& hold() const { return record_.hold; }
  std::vector<AlarmCondition> conditions() const { return queue_alarms(record_); }
  Result<void> check_stops() const { return parts_.stops.check(); }  // errors: STOP_PENDING
  QueueEntryId next_id() const;
  std::int64_t first_place() const;  // of those that wait
  std::int64_t last_place() const;
  // Why each entry waits, by what was known at the last look; one that does not wait: none, empty.
  std::map<QueueEntryId, std::string> waits() const;
  std::string waits_for(QueueEntryId id) const;
  // By what runs of this cell took. only: those behind this entry are left out.
  std::map<QueueEntryId, EntryOutlook> outlooks(std::optional<QueueEntryId> only = {}) const;

 private:
  // A follow-up that was made.
  struct Made {
    QueueResult result;
    std::optional<AlarmCondition> alarm;  // raised once the result is on record
  };

  Awaitable<void> look_for_ever();
  Awaitable<void> look();
  Awaitable<void> read_plans();
  Awaitable<void> draw_lengths();
  Awaitable<void> settle(QueueEntry entry);
  Awaitable<void> put_back(QueueEntry entry, std::string why, bool by_person);
  Awaitable<void> begin(QueueEntry entry, bool asked_for);
  Awaitable<void> follow(QueueEntryId id);
  Awaitable<Result<void>> store(QueueEntryId id, Made made);
  Awaitable<Made> make(const QueueEntry& entry, int position);
  Awaitable<Made> notice(const QueueEntry& entry);
  Awaitable<QueueResult> fit(const QueueEntry& entry, std::string formula);
  Awaitable<QueueResult> diagnose(const QueueEntry& entry, std::string baseline);
  Awaitable<QueueResult> report(const QueueEntry& entry);
  Awaitable<Result<ConditionVerdict>> look_at(std::string text);
  static Caller in_the_name_of(const QueueEntry& entry);
  void hold_by_stop();
  void add_repeat(const QueueEntry& entry, QueueChange& change) const;
  QueueSituation situation() const;
  std::string busy() const;

  asio::any_io_executor executor_;
  Parts parts_;
  AsyncMutex changing_;
  Signal wake_;
  QueueRecord record_;
  QueueHold last_stop_;     // since the start
  std::int64_t stops_ = 0;  // likewise
  std::map<QueueEntryId, ConditionVerdict> conditions_;
  std::map<QueueEntryId, EntryLength> lengths_;  // of entries that wait
  std::map<QueueEntryId, std::string> refused_;  // why a start was put off
  std::map<QueueEntryId, Made> made_;            // follow-ups whose result is not on record yet
  std::shared_ptr<void> run_watch_;
  bool asked_ = false, woken_ = false, following_ = false, drawing_ = false, ending_ = false;
};

}  // namespace driftwise::application
