#pragma once
// The studies under way (studies.h). Executor's thread; what the worker shares with it are a
// Study's flag and what it posts.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <vector>

#include "server/application/analyses/studies.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

// What the worker's half of a study uses: says where it stands, and shares out its work.
class StudyBench {
 public:
  StudyBench(asio::any_io_executor executor, std::shared_ptr<Study> study);
  ~StudyBench();
  void say(double fraction, const std::string& step);
  // For a fit's options: jobs on `threads` threads, none of which begins once the study was
  // stopped. counted: says step and the share of jobs that are done; for one call only.
  calibration::Executor sharing(int threads) const;
  calibration::Executor counting(int threads, const std::string& step);

 private:
  struct Voice;
  std::shared_ptr<Study> study_;
  std::shared_ptr<Voice> voice_;
};

class StudyDesk {
 public:
  static constexpr std::size_t kMostAtOnce = 8;  // under way or waiting for the one before

  StudyDesk(asio::any_io_executor executor, asio::any_io_executor worker, TaskGroup& tasks);

  // work: on the worker's thread. Errors: its own; cancelled; resource_exhausted TOO_MANY_STUDIES.
  template <class Answer>
  Awaitable<Result<Answer>> carry_out(std::shared_ptr<Study> study,
                                      std::function<Result<Answer>(StudyBench&)> work);
  // All are stopped, and none begins.
  void shut_down();

 private:
  Result<void> may_begin(const std::shared_ptr<Study>& study);
  void leave(const std::shared_ptr<Study>& study);

  asio::any_io_executor executor_, worker_;
  TaskGroup& tasks_;
  std::vector<std::shared_ptr<Study>> studies_;
  bool ending_ = false;
};

struct StudyStopped {};  // thrown through a fit by a study that was stopped

inline tl::unexpected<Error> study_was_stopped() {
  return fail(ErrorCode::cancelled, reasons::kCancelled, "the study was stopped");
}

template <class Answer>
Awaitable<Result<Answer>> StudyDesk::carry_out(std::shared_ptr<Study> study,
                                               std::function<Result<Answer>(StudyBench&)> work) {
  DRIFTWISE_CO_RETURN_IF_ERROR(may_begin(study));
  const auto task = tasks_.join();
  study->tell({"waiting for its turn", 0});
  std::function<Result<Answer>()> guarded = [study, work = std::move(work),
                                             executor = executor_]() -> Result<Answer> {
    if (study->stopped()) return study_was_stopped();
    StudyBench bench(executor, study);
    try {
      return work(bench);
    } catch (const StudyStopped&) {
      return study_was_stopped();
    }
  };
  auto answer = co_await run_on(
      worker_, [](const std::function<Result<Answer>()>& job) { return job(); },
      std::move(guarded));
  leave(study);
  co_return answer;
}

}  // namespace driftwise::application
