#pragma once
// Runs: begin, steer, watch. Finished runs and their points are read from the store
// (plumbing/store_reader.h). Executor's thread.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/application/ports/run_hold.h"
#include "server/application/runs/run_progress.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct CreateRun {
  std::string name, trajectory_name, trajectory_text, request_id;
  std::string lease_token;
  std::optional<RunRules> rules;
  bool compensate = false;                 // x_mm trajectories: move to the serving model's targets
  std::optional<ModelId> compensate_with;  // this model instead of the serving one
  std::string setup = {};                  // [[setup]] of the cell file; empty: all instruments
  RunMetadata metadata = {};
  std::optional<QueueEntryId> queue_entry = {};  // that it is the turn of
  // Why the robot is about to move without a person having asked for it now: told for a minute
  // before the first motion. Empty: a person has.
  std::string announce = {};
  // Nothing is created and no right to move is needed: the answer is the record as it would be,
  // without an id (0).
  bool validate_only = false;
};

class Runs {
 public:
  virtual ~Runs() = default;

  // The same request_id again answers with the first run. Errors: those of RightToMove::check and
  // Trajectories::check; invalid_argument NO_SUCH_SETUP, BAD_RULE, NOTHING_TO_COMPENSATE,
  // NEEDS_COMPENSATION; failed_precondition NO_MODEL, with several robots NO_PLAN, and what
  // check_joint_rows refuses; aborted STOPPED_MEANWHILE.
  virtual Awaitable<Result<RunRecord>> create(Caller caller, CreateRun request) = 0;
  virtual Awaitable<Result<RunRecord>> pause(Caller caller, RunId run) = 0;
  // Errors: those of check_answer (run_hold.h); failed_precondition MOVING.
  virtual Awaitable<Result<RunRecord>> resume(Caller caller, RunId run, HoldAnswer answer) = 0;
  virtual Awaitable<Result<RunRecord>> abort(Caller caller, RunId run, std::string why) = 0;
  // A person says that the force the run waits for acts now. Errors: failed_precondition
  // NO_FORCE_WANTED (the run does not wait for one), invalid_argument WRONG_FORCE (another one than
  // the run waits for).
  virtual Awaitable<Result<RunRecord>> confirm_force(Caller caller, RunId run, double force_n) = 0;
  // Sets and removes metadata. Errors: not_found NO_SUCH_RUN, invalid_argument BAD_METADATA.
  virtual Awaitable<Result<RunRecord>> tag(Caller caller, RunId run, RunMetadata set,
                                           std::vector<std::string> removed) = 0;
  // The run under way as it is now, any other from the store. Errors: not_found NO_SUCH_RUN.
  virtual Awaitable<Result<RunRecord>> get(RunId run) = 0;
  // Calls back with every change of the run under way until the handle is destroyed; at once with
  // the present state.
  virtual std::shared_ptr<void> watch(std::function<void(const RunProgress&)> on_change) = 0;
};

}  // namespace driftwise::application
