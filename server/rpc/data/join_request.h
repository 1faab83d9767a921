#pragma once
// JoinRunsRequest -> the application's request.

#include "driftwise/v1/data_service.pb.h"
#include "server/application/datasets/datasets.h"

namespace driftwise::rpc {

// Errors: BAD_ID, TOO_MANY_RUNS, DUPLICATE_RUN, TOO_LONG; BAD_LIMIT (a limit that is no positive
// number).
Result<application::JoinRequest> join_from(const v1::JoinRunsRequest& request);

}  // namespace driftwise::rpc
