#include "server/locks/claims.h"

#include "server/core/reasons.h"

namespace driftwise::locks {

Result<void> Claims::take(const std::string& device, const std::string& key) {
  if (held_.contains(key)) return {};
  auto lock = KernelLock::take("controller/" + key);
  if (lock) {
    held_.emplace(key, std::move(*lock));
    return {};
  }
  if (lock.error().reason != reasons::kLockHeld) return tl::unexpected(lock.error());
  return fail(ErrorCode::failed_precondition, reasons::kControllerInUse,
              "device '" + device + "': its controller (" + key + ") is driven by " +
                  lock.error().message +
                  ": stop that daemon, or give this cell a controller of its own");
}

}  // namespace driftwise::locks
