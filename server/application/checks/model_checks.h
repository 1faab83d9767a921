#pragma once
// Models against new measurements: the check standard, and what compensation achieved. Executor's
// thread; the figures are worked out on the worker's.

#include <optional>
#include <vector>

#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"
#include "server/diagnosis/check/check_standard.h"
#include "server/diagnosis/check/verification.h"

namespace driftwise::application {

struct ModelCheck {  // does the robot still do what a model says?
                     // server/diagnosis/check/check_standard.h
  ModelId model;
  std::vector<RunRecord> runs;  // those looked at, in order of time
  diagnosis::CheckReport report;
};

class ModelChecks {
 public:
  virtual ~ModelChecks() = default;

  // model: none means the one that serves. runs: empty means every measured run since the model was
  // made that it was not fitted from, the last 50 of them. leaving_out: a correction that the
  // readings are looked at without, as if it had not been accepted. Errors: failed_precondition
  // NO_MODEL.
  virtual Awaitable<Result<ModelCheck>> check_model(
      std::optional<ModelId> model, std::vector<RunId> runs,
      std::optional<CorrectionId> leaving_out = {}) = 0;
  // Target minus measured of runs: server/diagnosis/check/verification.h. range: whose range says
  // inside and outside; none: each run's own model. Errors: those of verify_runs(); NO_SUCH_RUN,
  // _MODEL.
  virtual Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId> runs,
                                                                 std::optional<ModelId> range) = 0;
};

}  // namespace driftwise::application
