#pragma once
// The model and the plan that answer targets, in words.

#include <string>

#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/plan_service.pb.h"

namespace driftwise::cli {

// A model answers targets of one robot, a plan those of several: "model 3, plan 2 (both)". Where
// nothing serves: what to do. Pure.
std::string serving_text(const v1::GetStatusResponse& status, const v1::ListPlansResponse& plans);

}  // namespace driftwise::cli
