#pragma once
// A separating plan as a diagnosis carries it: its trajectory as the text that can be run.

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/separating/separating.h"

namespace driftwise::formats {

diagnosis::SeparatingExperiment separating_text(const diagnosis::SeparatingPlan& plan);

}  // namespace driftwise::formats
