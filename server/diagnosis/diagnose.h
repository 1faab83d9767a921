#pragma once
// The door of the room: dataset and options in, diagnosis out (answer/diagnosis.h).

#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

// Errors: invalid_argument UNKNOWN_CHANNEL, NO_OUTPUT, TOO_FEW_ROWS, TIME_RUNS_BACK, UNTIMED (the
// baseline has an effect with memory), NOTHING_VARIES (the output is one number); cancelled.
Result<Diagnosis> diagnose(const Dataset& dataset, const DiagnoseOptions& options);

}  // namespace driftwise::diagnosis
