#include "server/application/runs/trouble.h"

#include "server/application/recording/device_bench.h"
#include "server/core/reasons.h"

namespace driftwise::application {

bool is_of_weights(const Error& error) {
  return error.reason == reasons::kLoadJammed || error.reason == reasons::kLoadSlow ||
         error.reason == reasons::kLoadBusy;
}

Remedy remedy_for(const Error& error) {
  switch (recovery_of(error.reason)) {
    case driftwise::Recovery::leave:
      return Remedy::leave;
    case driftwise::Recovery::abort:
      return Remedy::abort;
    case driftwise::Recovery::new_datum:
      return Remedy::new_datum;
    case driftwise::Recovery::fail:
      return Remedy::fail;
    case driftwise::Recovery::hold:
      return Remedy::hold;
    case driftwise::Recovery::by_code:
      break;
  }
  if (error.code == ErrorCode::aborted) return Remedy::hold;
  // A device that is away, and a device or thermometer that says "not now": both are looked at
  // again until they say something else. The engine counts, and asks for a person when nothing gets
  // better.
  if (is_device_loss(error) || error.code == ErrorCode::failed_precondition)
    return Remedy::wait_for_device;
  return Remedy::fail;
}

}  // namespace driftwise::application
