#pragma once
// Targets: a request's pose -> compensation::TargetRequest, and the answer back with its flags by
// name.

#include <google/protobuf/repeated_field.h>

#include "driftwise/v1/target_service.pb.h"
#include "server/compensation/target.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Errors: invalid_argument; BAD_POSE (a channel that is neither pose nor force, or not in mm,
// arcsec, N), MISSING_VALUE, NOT_FINITE, DUPLICATE_CHANNEL. No allocation unless it fails.
Result<compensation::TargetRequest> pose_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& pose, CellTime now);

// Fills out. Errors: those of compensation::refusal_error.
Result<void> answer_target(const compensation::Snapshot& snapshot,
                           const compensation::TargetRequest& request, bool with_budget,
                           v1::Target& out);

}  // namespace driftwise::rpc
