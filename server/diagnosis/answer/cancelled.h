#pragma once
// What a diagnosis ends with when its caller said stop.

#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

inline tl::unexpected<Error> cancelled() {
  return fail(ErrorCode::cancelled, reasons::kCancelled, "the diagnosis was cancelled");
}

}  // namespace driftwise::diagnosis
