#pragma once
// UTC for people, from a clock that people may set. Cell time runs on the monotonic clock; this
// watch compares the computer's wall clock with it, twice a second of wall time. When the wall
// clock has been set, UTC is mapped anew from that instant on: an event with the size, and an alarm
// above 1 s. The map is the clock's (Clock::utc), and the database keeps it, so that it holds
// across restarts. Executor's thread.

#include <functional>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/ports/clock_store.h"

namespace driftwise::application {

// What a start of the daemon finds: the map so far, and this start as its last entry.
struct ClockStart {
  std::vector<ClockRecord> records;  // oldest first; the last one is to be stored
};

// Begins the clock's cell time behind everything on record, and maps UTC. Within one start of the
// computer cell time goes on where it was, and a step of the wall clock meanwhile shows. Once,
// before anybody waits.
ClockStart begin_cell_time(Clock& clock, std::vector<ClockRecord> before,
                           CellTime newest_on_record);

class WallClockWatch {
 public:
  static constexpr auto kEvent = std::chrono::milliseconds(1);  // below: noise of the comparison
  static constexpr auto kAlarm = std::chrono::seconds(1);

  // alarm: told of a step above kAlarm.
  WallClockWatch(asio::any_io_executor executor, Clock& clock, StoreWriter& writer,
                 EventLog& events, TaskGroup& tasks, std::function<void(AlarmCondition)> alarm);

  void start(ClockStart start);
  void shut_down();

 private:
  Awaitable<void> watch();
  Awaitable<void> look();
  void tell_of_start(const ClockRecord& start);

  asio::any_io_executor executor_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::function<void(AlarmCondition)> alarm_;
  std::vector<ClockRecord> records_;
  bool ending_ = false;
  Signal ended_;
};

}  // namespace driftwise::application
