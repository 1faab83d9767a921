#pragma once
// Refusals of the store that pass: nothing was written, and the very same call may succeed later.

#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::application {

// The one rule of everybody who tries again: a disk that is full, can only be read or answers with
// an error, a database that another program holds or whose file was taken away, want of memory.
inline bool may_be_stored_later(const Error& refusal) {
  if (refusal.reason == reasons::kDatabaseLocked || refusal.reason == reasons::kDiskError)
    return true;
  return refusal.code == ErrorCode::resource_exhausted &&
         refusal.reason != reasons::kTooManyChannels;
}

}  // namespace driftwise::application
