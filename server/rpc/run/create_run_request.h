#pragma once
// CreateRun's request -> domain, with its checks; a trajectory's check -> proto.

#include "driftwise/v1/run_service.pb.h"
#include "server/application/runs/runs.h"
#include "server/application/trajectories/trajectories.h"

namespace driftwise::rpc {

// Errors: invalid_argument; TOO_LONG, BAD_RULE, BAD_DURATION, BAD_ID, EMPTY_TRAJECTORY,
// MODEL_WITHOUT_COMPENSATE.
Result<application::CreateRun> create_run_from(const v1::CreateRunRequest& request,
                                               const RunRules& cell_rules);

v1::CheckTrajectoryResponse check_response_from(const application::TrajectoryCheck& check);

}  // namespace driftwise::rpc
