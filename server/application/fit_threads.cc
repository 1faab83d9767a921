#include "server/application/fit_threads.h"

#include <algorithm>

#include "server/calibration/threads.h"

namespace driftwise::application {

calibration::Executor fit_threads(int wanted) {
  return calibration::threaded_executor(std::min(wanted, calibration::processors()));
}

}  // namespace driftwise::application
