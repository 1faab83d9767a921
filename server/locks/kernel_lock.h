#pragma once
// Lock of a name within this computer: an abstract unix socket that is bound to it. The kernel
// releases it with the process, also after SIGKILL, so nothing can be left behind and nothing can
// be deleted under its holder.
//
// Limits: processes in another network namespace (some containers) and on other computers do not
// see it. Any local user may hold any name. Source: unix(7), "Abstract sockets".

#include <string>
#include <utility>

#include "server/core/result.h"

namespace driftwise::locks {

class KernelLock {
 public:
  KernelLock() = default;  // holds nothing
  // name: at most 100 bytes. Errors: failed_precondition LOCK_HELD, its message is the holder
  // ("process 4711"), also when this very process holds it; internal NO_LOCK (no descriptor left).
  static Result<KernelLock> take(const std::string& name);
  ~KernelLock();
  KernelLock(KernelLock&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  KernelLock& operator=(KernelLock&& other) noexcept {
    std::swap(socket_, other.socket_);
    return *this;
  }

 private:
  explicit KernelLock(int socket) : socket_(socket) {}
  int socket_ = -1;
};

}  // namespace driftwise::locks
