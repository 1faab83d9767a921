#pragma once

#include <functional>
#include <string>

#include "server/core/data/dataset.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::application {

// diagnosis::diagnose, or what a test has instead.
using Diagnose =
    std::function<Result<diagnosis::Diagnosis>(const Dataset&, const diagnosis::DiagnoseOptions&)>;

struct DiagnosisProgress {
  DiagnosisId id;
  JobState state = JobState::running;
  std::string step;     // "looking for a second cause in q1"
  double fraction = 0;  // 0 to 1, never backwards
};

}  // namespace driftwise::application
