#pragma once
// The rest under way: begun, ended by whatever moves, its record of when. Executor's thread.

#include <optional>

#include "server/application/commissioning/commissioning.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/recording/recorder.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"

namespace driftwise::application {

class RestDesk {
 public:
  struct Rest {
    CellTime begin, end;  // end 0: under way
    std::string begun_by, end_reason;
    RestLimits limits;
  };

  RestDesk(asio::any_io_executor executor, Clock& clock, Recorder& recorder, EventLog& events,
           RunEngine& engine, RightToMove& right, TaskGroup& tasks);
  Result<void> begin(const Caller& caller, RestLimits limits);
  Result<void> end(const Caller& caller);
  void shut_down();
  const std::optional<Rest>& last() const { return rest_; }

 private:
  Awaitable<void> watch();
  void finish(std::string why);

  Clock& clock_;
  Recorder& recorder_;
  EventLog& events_;
  RunEngine& engine_;
  RightToMove& right_;
  TaskGroup& tasks_;
  Signal ended_;
  std::optional<Rest> rest_;
};

}  // namespace driftwise::application
