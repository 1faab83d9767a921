#pragma once
// Improvements: the loop of improvement_loop.h, begun, cancelled, watched. Their records are read
// from the store. Executor's thread.

#include <functional>
#include <memory>
#include <string>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct ImproveRequest {
  std::string lease_token;
  std::string trajectory_name, trajectory_text;
  std::string formula;  // of the first model; empty: the model that serves
  int max_turns = 5;
  double budget_s = 0;  // of cell time; 0: no limit
  // A model whose gain fresh points have shown serves. Else it is proposed, and a person promotes
  // it.
  bool promotes = false;
  std::string setup = {};  // [[setup]] of the cell file; empty: all instruments
  std::string request_id;
  // Of a cell with several robots: "ma". Empty: the one that the formula's outputs name.
  std::string robot = {};
};

struct ImprovementProgress {
  ImprovementId id;
  JobState state = JobState::running;
  int turn = 0;
  std::string step;  // "measuring 40 fresh points"
};

class Improvements {
 public:
  virtual ~Improvements() = default;

  // Errors: those of Runs::create; invalid_argument BAD_TURNS, BAD_BUDGET; failed_precondition
  // IMPROVEMENT_UNDER_WAY.
  virtual Awaitable<Result<ImprovementRecord>> create(Caller caller, ImproveRequest request) = 0;
  virtual Awaitable<Result<ImprovementRecord>> cancel(Caller caller, ImprovementId id) = 0;
  // Of every improvement until the handle is destroyed; at once of the one under way.
  virtual std::shared_ptr<void> watch(
      std::function<void(const ImprovementProgress&)> on_change) = 0;
};

}  // namespace driftwise::application
