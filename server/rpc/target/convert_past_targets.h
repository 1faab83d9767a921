#pragma once
// What a target would have been: request and answer.

#include "driftwise/v1/target_service.pb.h"
#include "server/application/serving/targets.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Errors: those of pose_from and nanoseconds_from; invalid_argument BAD_PAST (shorter than a minute
// or longer than a day), BAD_COUNT (not 2 to 500).
Result<application::PastTargetsQuery> past_targets_query_from(
    const v1::ListPastTargetsRequest& request);

void fill_past_targets(const application::PastTargets& from, v1::ListPastTargetsResponse& out);

}  // namespace driftwise::rpc
