#pragma once
// Targets: a request's pose -> compensation::TargetRequest, and the answer back with its flags by
// name.

#include <google/protobuf/repeated_field.h>

#include <map>
#include <string>

#include "driftwise/v1/target_service.pb.h"
#include "server/compensation/forward_pose.h"
#include "server/compensation/target.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Errors: invalid_argument; BAD_POSE (a channel that is neither pose nor force, or not in mm,
// arcsec, N), MISSING_VALUE, NOT_FINITE, DUPLICATE_CHANNEL. No allocation unless it fails.
Result<compensation::TargetRequest> pose_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& pose, CellTime now);

// "q2_rad", "q2_deg": the angles that of an arm's solutions the nearest is wanted to. Errors:
// invalid_argument; BAD_CHANNEL (no joint angle), MISSING_VALUE, NOT_FINITE, DUPLICATE_CHANNEL.
Result<void> take_near(const google::protobuf::RepeatedPtrField<v1::ChannelValue>& near,
                       compensation::TargetRequest& request);

// Fills out. Errors: those of compensation::refusal_error.
Result<void> answer_target(const compensation::Snapshot& snapshot,
                           const compensation::TargetRequest& request, bool with_budget,
                           v1::Target& out);

// Live values of the cell by channel name, for what a request leaves out.
using Present = std::map<std::string, double>;

// Fills out. Errors: those of forward_pose; invalid_argument BAD_CHANNEL (not a motor coordinate of
// the model), failed_precondition MISSING_VALUE (not read lately).
Result<void> answer_pose(const compensation::Snapshot& snapshot,
                         const v1::EstimatePoseRequest& request, const Present& present,
                         CellTime now, v1::EstimatePoseResponse& out);

}  // namespace driftwise::rpc
