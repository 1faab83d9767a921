#pragma once
// How many threads a fit may have beside the cell's own work.

#include "server/calibration/model/executor.h"

namespace driftwise::application {

// Jobs on up to `wanted` threads, the caller's among them, and never more than there are
// processors; 1 or less: here, one after the other. A job's exception is thrown here when all are
// done. The model does not depend on the number (server/calibration/fit.h).
calibration::Executor fit_threads(int wanted);

}  // namespace driftwise::application
