#pragma once
// After the loss of a device: wait until everything that a point needs is there again, and look at
// what was lost.

#include "server/application/motion/workbench.h"

namespace driftwise::application {

struct Recovery {
  bool reference_lost = false;
  bool servo_off = false;
  bool beam_lost = false;
  bool waited = false;  // something was not there at the first look
};

// Ends when every device is prepared, the axes answer, the interferometers answer (or say that the
// beam was lost) and every temperature is fresh. Tries again with growing pauses, 1 to 10 s of cell
// time, for as long as it takes. Errors: aborted, cancelled.
Awaitable<Result<Recovery>> wait_for_devices(RunScope& scope);

}  // namespace driftwise::application
