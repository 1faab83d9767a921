#pragma once
// Stops on record: the first of a burst at once, all that follow it as one event with their count.
//
// A burst is over when nobody has asked for a stop for kQuiet. While it lasts the count is told
// every kTold. Stopping itself is not delayed or dropped: only the record is. Executor's thread.

#include <optional>
#include <set>
#include <string>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/task_group.h"

namespace driftwise::application {

class StopEvents {
 public:
  static constexpr std::chrono::seconds kQuiet{10}, kTold{600};  // cell time

  StopEvents(asio::any_io_executor executor, Clock& clock, EventLog& events, TaskGroup& tasks)
      : executor_(executor), clock_(clock), events_(events), tasks_(tasks), ended_(executor) {}

  // run: the one under way, in whose log the stop is.
  void record(const Caller& caller, std::optional<RunId> run = {});
  void shut_down();  // what was counted is told
  // Of all stops since the start: who waits for something before a motion looks whether it grew.
  std::int64_t presses() const { return presses_; }
  // What the last stop since the start makes a run stand for.
  const RunHold& hold() const { return hold_; }

 private:
  Awaitable<void> wait_out();
  void tell();

  asio::any_io_executor executor_;
  Clock& clock_;
  EventLog& events_;
  TaskGroup& tasks_;
  Signal ended_;
  CellTime last_, told_;
  RunHold hold_;
  std::optional<RunId> run_;
  std::int64_t further_ = 0, in_all_ = 0, presses_ = 0;
  std::set<std::string> names_;  // of those who asked again, the first few
  bool bursting_ = false, ending_ = false;
};

}  // namespace driftwise::application
