#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>

#include "server/application/models/models.h"
#include "server/application/motion/stop_events.h"
#include "server/application/motion/workbench.h"
#include "server/application/plans/joint_serving.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"
#include "server/application/runs/runs.h"
#include "server/application/serving/serving.h"
#include "server/application/trajectories/trajectories.h"

namespace driftwise::application {

// Errors: invalid_argument NOTHING_TO_COMPENSATE, NEEDS_COMPENSATION. name: of the file.
Result<void> check_coordinates(const std::string& name, const Trajectory& trajectory,
                               bool compensate);

class RunsService final : public Runs {
 public:
  // All of them outlive this.
  RunsService(Workbench& bench, StoreReader& reader, RunEngine& engine, RightToMove& right,
              StopEvents& stop_events, Trajectories& trajectories, Models& models, Serving& serving,
              const JointServing& joint_serving, const ConfigurationBook& configuration,
              asio::any_io_executor background);

  Awaitable<Result<RunRecord>> create(Caller caller, CreateRun request) override;
  Awaitable<Result<RunRecord>> pause(Caller caller, RunId run) override;
  Awaitable<Result<RunRecord>> resume(Caller caller, RunId run, HoldAnswer answer) override;
  Awaitable<Result<RunRecord>> abort(Caller caller, RunId run, std::string why) override;
  Awaitable<Result<RunRecord>> confirm_force(Caller caller, RunId run, double force_n) override;
  Awaitable<Result<RunRecord>> tag(Caller caller, RunId run, RunMetadata set,
                                   std::vector<std::string> removed) override;
  Awaitable<Result<RunRecord>> get(RunId run) override;
  std::shared_ptr<void> watch(std::function<void(const RunProgress&)> on_change) override;

  // Once, before anybody may begin one: the run that was under way when the daemon ended continues
  // (unfinished_run.cc).
  Awaitable<Result<void>> continue_unfinished();

 private:
  struct Prepared {
    RunPlan plan;
    Trajectory trajectory;
  };
  Awaitable<Result<Prepared>> prepare(const CreateRun& request);
  Awaitable<Result<RunRecord>> would_be(const CreateRun& request, const Prepared& prepared);
  // unfinished_run.cc
  Awaitable<Result<std::optional<RunRecord>>> find_unfinished();
  Awaitable<Result<RunBasis>> read_basis(RunRecord record);
  Awaitable<Result<RunBefore>> what_was_before(const RunRecord& run);
  Awaitable<Result<void>> follow_for(const RunPlan& plan);
  // What the targets of a compensated run's rows come from, as it is now.
  Awaitable<Result<void>> settle_compensation(RunPlan& plan, const Trajectory& trajectory,
                                              const std::string& name);
  Awaitable<Result<RunRecord>> start_run(Caller caller, CreateRun request, RunPlan plan,
                                         Trajectory trajectory);
  RunRecord present() const;
  // Of the run under way. It ends with the run: not to be kept over a wait.
  Result<RunControl*> control_of(RunId run, const char* verb);
  // Whether this person may end the hold of this run now. Errors: those of StopDesk::check;
  // CONFIGURATION_CHANGED, RUN_NOT_UNDER_WAY, MOVING; those of check_answer.
  Result<RunControl*> check_resume(const Caller& caller, RunId id, const HoldAnswer& answer);
  // Errors: RUN_NOT_UNDER_WAY; those of RunControl::check; NO_FORCE_WANTED, WRONG_FORCE.
  Result<void> check_confirmation(RunId id, double force_n);
  Awaitable<Result<RunRecord>> steer(Caller caller, RunId run, const char* verb, std::string detail,
                                     std::function<void(RunControl&)> act);

  const CellDescription& description_;
  Clock& clock_;
  Recorder& recorder_;
  StoreWriter& writer_;
  EventLog& events_;
  StopDesk& stops_;
  Doubts& doubts_;
  const std::string& boot_id_;
  StoreReader& reader_;
  RunEngine& engine_;
  RightToMove& right_;
  StopEvents& stop_events_;
  Trajectories& trajectories_;
  Models& models_;
  Serving& serving_;
  const JointServing& joint_serving_;
  const ConfigurationBook& configuration_;
  asio::any_io_executor background_;
};

}  // namespace driftwise::application
