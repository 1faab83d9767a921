#pragma once
// Tells receivers outside the machine of alarms: each at least once, in its own pace, through the
// store. A message counts when its receiver has said so and the store has it; what a kill leaves
// open is told at the next start, perhaps a second time. Receivers do not wait for one another, and
// the cell waits for none of them: the calls run on threads of their own.
//
// Executor's thread.

#include <boost/asio/any_io_executor.hpp>
#include <compare>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "server/application/notify/life_signs.h"
#include "server/application/notify/news_rules.h"
#include "server/application/notify/notifications.h"
#include "server/application/notify/refused_recipients.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/plumbing/watch_list.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/ports/outside/notifier.h"

namespace driftwise::application {

class NotifyDesk final : public Notifications {
 public:
  // A receiver that takes nothing for so long is itself an alarm: cell time, and at least as much
  // wall time.
  static constexpr double kFailing_s = 60;
  static constexpr std::size_t kManyKnown = 100;  // alarms; above it those that are told are let go
  static constexpr double kFirstRetry_s = 1, kLongestRetry_s = 300;

  struct Parts {  // all of them outlive this
    Clock& clock;
    StoreWriter& writer;
    StoreReader& reader;
    EventLog& events;
    TaskGroup& tasks;
    WatchList<AlarmRecord>& alarms;
    Notifier* notifier = nullptr;  // nullptr: nobody is told
    asio::any_io_executor threads = {};
    // Alarms that the store has not taken yet (a full disk): told all the same.
    std::function<std::vector<AlarmRecord>()> unstored = {};
  };
  struct Rules {
    std::string cell, version, web_address;
    std::vector<ReceiverDescription> receivers;
    WatchdogRules watchdog;
  };
  // run: what a sign of life says of the run under way.
  NotifyDesk(asio::any_io_executor executor, Parts parts, Rules rules, LifeSigns::Run run);

  void start();
  void shut_down();

  std::vector<ReceiverStatus> receivers() const override;
  Awaitable<Result<std::vector<TellingRecord>>> tellings(int limit) override;
  Awaitable<Result<std::string>> test(Caller caller, std::string receiver) override;

  // notify.failed of each receiver that takes nothing and of each recipient of a mail who is
  // refused, watchdog.unreached.
  std::vector<AlarmCondition> conditions() const;
  // Whether such a condition of before the start was looked at since: something arrived there, or
  // the cell file has it no longer.
  bool has_judged(const std::string& kind, const std::string& subject) const;

 private:
  struct Known {
    AlarmRecord alarm;
    std::map<std::string, TellingRecord> told;  // by receiver
  };
  struct Receiver {
    ReceiverDescription description;
    CellTime known_since, next_try, delivered, failing_since;
    double retry_s = 0;
    std::string answer;
    std::int64_t waiting = 0;
    RefusedRecipients refused = {};
  };

  void take(const AlarmRecord& alarm);
  void take_unstored();
  Awaitable<void> begin();
  Awaitable<bool> restore();
  Awaitable<void> serve(Receiver& receiver);
  Awaitable<void> tell(Receiver& receiver, Notice notice);
  Awaitable<void> tell_again(Receiver& receiver, RefusedRecipients::Due due);
  // What the receiver knows of the alarm of this news; nullptr: it is forgotten.
  TellingRecord* telling_of(const Receiver& receiver, const AlarmNews& news);
  Awaitable<void> keep(std::vector<TellingRecord> tellings);
  NewsQuestion question(const Receiver& receiver, const Known& known) const;
  Notice due_notice(Receiver& receiver);
  void forget_what_is_over();
  Awaitable<void> pause();

  asio::any_io_executor executor_;
  Parts parts_;
  Rules rules_;
  std::vector<std::unique_ptr<Receiver>> receivers_;
  std::map<std::int64_t, Known> known_;  // by alarm; below 0: not stored yet
  // Those of which nothing more is told. A later change (an acknowledgement, the end of a shelf)
  // does not make them news: what was told of them is in the store only.
  std::set<std::int64_t> finished_;
  struct Occurrence {
    std::string kind, subject;
    std::int64_t since_ns = 0;
    auto operator<=>(const Occurrence&) const = default;
  };
  std::map<Occurrence, std::int64_t> provisional_;  // their numbers in known_
  std::vector<TellingRecord> unstored_;
  std::shared_ptr<void> watch_;
  LifeSigns signs_;
  Signal wake_;
  bool ending_ = false;
};

}  // namespace driftwise::application
