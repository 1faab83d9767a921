#pragma once
// Signs of life to a watchdog on another machine, every_s of wall time, each with the head of the
// record's chain. They are sent by the executor's own coroutine: an executor that is stuck falls
// silent. Executor's thread.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "server/application/notify/notifications.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/ports/clock.h"
#include "server/core/ports/outside/notifier.h"

namespace driftwise::application {

class LifeSigns {
 public:
  static constexpr std::chrono::seconds kFailing{60};  // wall time until it is an alarm

  struct Parts {  // all of them outlive this
    Clock& clock;
    StoreReader& reader;
    TaskGroup& tasks;
    Notifier* notifier = nullptr;
    asio::any_io_executor threads = {};
    std::function<std::vector<AlarmRecord>()> unstored = {};  // alarms that are not on record yet
  };
  struct Rules {
    std::string cell, version;
    WatchdogRules watchdog;
  };
  // Fills in what a sign says of the run under way.
  using Run = std::function<void(LifeSign&)>;

  LifeSigns(asio::any_io_executor executor, Parts parts, Rules rules, Run run);

  void start();
  void shut_down();
  std::optional<ReceiverStatus> status() const;
  std::optional<AlarmCondition> condition() const;
  // One arrived since the start, or none is sent.
  bool has_judged() const { return rules_.watchdog.url.empty() || delivered_.utc_ns != 0; }

 private:
  Awaitable<void> send_for_ever();
  Awaitable<LifeSign> sign();

  Parts parts_;
  Rules rules_;
  Run run_;
  asio::steady_timer timer_;
  CellTime delivered_, failing_since_;
  std::optional<std::chrono::steady_clock::time_point> failing_from_;  // wall time
  std::string answer_;
  bool ending_ = false;
};

}  // namespace driftwise::application
