#pragma once
#include "server/calibration/fit.h"

namespace driftwise::cli {

// Runs the jobs of a fit on up to `threads` threads, this one among them; 1 or less: here, one
// after the other. A job's exception is thrown here when all are done. The model does not depend on
// the number: what is summed together depends on the data alone (server/calibration/fit.h).
calibration::Executor worker_threads(int threads);

int default_threads();  // one per processor

}  // namespace driftwise::cli
