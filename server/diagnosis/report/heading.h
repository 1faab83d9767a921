#pragma once
// The accuracy that heads a diagnosis, and whether held-out rows got worse.

#include <string>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

// Every output as judged, after the findings, with what it was before on the same rows: held-out
// rows, or the calibration rows where nothing was held out.
std::vector<JudgedAccuracy> judged_accuracies(const Diagnosis& diagnosis);

// Per unit the output with the largest A90 after the findings, with its own A90 before.
std::vector<JudgedAccuracy> heading_of(const Diagnosis& diagnosis);

// Held-out A90 that the findings made larger by more than a twentieth, such as
// "q2: 13.5 -> 17.0 nm"; empty: none. The verdict is printed with them.
std::vector<std::string> outputs_made_worse(const Diagnosis& diagnosis);

}  // namespace driftwise::diagnosis
