#pragma once
// The procedure and a design study: domain -> proto.

#include "driftwise/v1/study_service.pb.h"
#include "server/application/procedure/procedure_steps.h"
#include "server/compensation/design_study.h"

namespace driftwise::rpc {

v1::ProcedureStep step_from(const application::ProcedureStep& step);
void put(const compensation::DesignStudy& study, v1::StudyDesignResponse& out);

}  // namespace driftwise::rpc
