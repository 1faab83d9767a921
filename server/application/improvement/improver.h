#pragma once
// The improvement under way, one at a time: on record from its first turn to its end. Executor's
// thread.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <optional>

#include "server/application/improvement/improvement_loop.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/plumbing/watch_list.h"

namespace driftwise::application {

class Improver {
 public:
  // All of them outlive this.
  Improver(asio::any_io_executor executor, ImprovementServices services, Clock& clock,
           StoreWriter& writer, EventLog& events, TaskGroup& tasks);
  ~Improver();

  // The same request_id again answers with the first one. Errors: failed_precondition
  // IMPROVEMENT_UNDER_WAY.
  Awaitable<Result<ImprovementRecord>> begin(Caller caller, ImproveRequest request,
                                             std::string formula);
  // Over at once, on record and for its watchers; does nothing to one that is over.
  Awaitable<Result<void>> cancel(Caller caller, ImprovementId id);

  // A person stopped the axes: the improvement under way ends, its run stands as it is. It never
  // continues after a stop, also when somebody resumes the run.
  void halt(const std::string& why);

  bool busy() const { return active_ != nullptr; }
  void tell_present(const std::function<void(const ImprovementProgress&)>& to) const;
  WatchList<ImprovementProgress>& watchers() { return watchers_; }
  void shut_down();

 private:
  struct Active;
  Awaitable<void> carry_out(std::shared_ptr<Active> active);
  // One try to store it, for whoever waits for the answer; what the database refuses is tried again
  // until it is taken or the daemon ends, and until then the improvement is under way.
  Awaitable<Result<void>> end(std::shared_ptr<Active> active, JobState state, std::string reason);
  Awaitable<void> store_later(std::shared_ptr<Active> active, JobState state, std::string reason,
                              CellTime at);
  void close(Active& active, JobState state, const std::string& refused);
  // The loop first: the robot halts before anything is written.
  Awaitable<Result<void>> stop_and_end(std::shared_ptr<Active> active, bool leave_run,
                                       JobState state, std::string reason);
  Awaitable<void> stop(std::shared_ptr<Active> active, std::string reason);

  asio::any_io_executor executor_;
  ImprovementServices services_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::shared_ptr<Active> active_;
  WatchList<ImprovementProgress> watchers_;
  bool beginning_ = false, ending_ = false;
};

}  // namespace driftwise::application
