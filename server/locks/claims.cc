#include "server/locks/claims.h"

namespace driftwise::locks {

Result<void> Claims::take(const std::string& device, const std::string& key) {
  if (held_.contains(key)) return {};
  auto lock = KernelLock::take("controller/" + key);
  if (lock) {
    held_.emplace(key, std::move(*lock));
    return {};
  }
  if (lock.error().reason != "LOCK_HELD") return tl::unexpected(lock.error());
  return fail(ErrorCode::failed_precondition, "CONTROLLER_IN_USE",
              "device '" + device + "': its controller (" + key + ") is driven by " +
                  lock.error().message +
                  ": stop that daemon, or give this cell a controller of its own");
}

}  // namespace driftwise::locks
