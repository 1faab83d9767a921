#include "server/application/plumbing/fit_threads.h"

#include <algorithm>

#include "server/threads/threaded_executor.h"

namespace driftwise::application {

calibration::Executor fit_threads(int wanted) {
  return threads::threaded_executor(std::min(wanted, threads::processors()));
}

}  // namespace driftwise::application
