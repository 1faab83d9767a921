#pragma once
// Accuracy figures: domain -> proto.

#include "driftwise/v1/accuracy.pb.h"
#include "server/core/data/accuracy.h"

namespace driftwise::rpc {

v1::ErrorFigures figures_from(const ErrorFigures& figures);
v1::JudgedAccuracy judged_from(const JudgedAccuracy& judged);

}  // namespace driftwise::rpc
