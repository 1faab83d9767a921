#pragma once
// The accuracy that heads a page, as the daemon gives it, in words.

#include <string>

#include "driftwise/v1/accuracy.pb.h"
#include "server/core/data/accuracy.h"

namespace driftwise::cli {

ErrorFigures figures_of(const v1::ErrorFigures& figures);

// "42.0 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)"; with before: "53.1 -> 42.0 nm
// (...)".
std::string accuracy_text(const v1::JudgedAccuracy& judged);

}  // namespace driftwise::cli
