#pragma once
// The rest under way: begun, ended by what moves, on record, continued after a restart. Executor's
// thread.

#include <optional>

#include "server/application/commissioning/commissioning.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/recording/recorder.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class RestDesk {
 public:
  struct Rest {
    std::int64_t id = 0;
    CellTime begin, end;  // end 0: under way
    std::string begun_by, end_reason;
    RestLimits limits;
  };

  RestDesk(asio::any_io_executor executor, Clock& clock, Recorder& recorder, StoreWriter& writer,
           EventLog& events, RunEngine& engine, RightToMove& right, TaskGroup& tasks);
  // On disk when they return.
  Awaitable<Result<void>> begin(Caller caller, RestLimits limits);
  Awaitable<Result<void>> end(Caller caller);
  // Once, at the start: a rest that was under way when the daemon ended goes on.
  Awaitable<Result<void>> continue_unfinished();
  void shut_down();
  const std::optional<Rest>& last() const { return rest_; }

 private:
  bool under_way() const { return rest_ && rest_->end.utc_ns == 0; }
  void follow();
  Awaitable<void> watch();
  // Over at once; on record when it returns, or as soon as the database takes it.
  Awaitable<Result<void>> finish(std::string why);
  Awaitable<void> store_end_later(Rest over);

  Clock& clock_;
  Recorder& recorder_;
  StoreWriter& writer_;
  EventLog& events_;
  RunEngine& engine_;
  RightToMove& right_;
  TaskGroup& tasks_;
  Signal ended_;
  AsyncMutex beginning_;
  bool watching_ = false, ending_ = false;
  std::optional<Rest> rest_;
};

}  // namespace driftwise::application
