#pragma once
// An executor that shares jobs among threads of its own, which end with the call. The mathematics
// start none themselves: the daemon and the command line hand this one in.

#include "server/calibration/model/executor.h"

namespace driftwise::threads {

// threads: at work, the caller's among them; below 2: none, the caller does all of it. The first
// exception of a job comes out of the call, the other threads' jobs under way are finished first.
calibration::Executor threaded_executor(int threads);

int processors();  // at least 1

}  // namespace driftwise::threads
