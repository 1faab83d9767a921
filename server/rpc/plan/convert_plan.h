#pragma once
// Plans and joint targets as messages.

#include <google/protobuf/repeated_field.h>

#include "driftwise/v1/plan_service.pb.h"
#include "server/application/plans/plans.h"
#include "server/core/result.h"
#include "server/plans/joint_target.h"

namespace driftwise::rpc {

v1::Plan plan_from(const PlanRecord& record, bool serves);
v1::PlanPromotion plan_promotion_from(const PlanPromotionRecord& record);
void fill_plan_check(const application::PlanReport& report, v1::CheckPlanResponse& out);

// Errors: invalid_argument UNKNOWN_NAME, DUPLICATE_NAME, MISSING_VALUE.
Result<plans::JointRequest> joint_request_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& pose,
    const plans::JointSnapshot& snapshot, CellTime now);

// Errors: those of plans::joint_refusal_error.
Result<void> answer_joint_target(const plans::JointSnapshot& snapshot,
                                 const plans::JointRequest& request, v1::JointTarget& out);

}  // namespace driftwise::rpc
