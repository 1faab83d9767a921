#pragma once
// The machines that this process drives: one kernel lock for each, held until the process ends.
// Thread: one.

#include <map>
#include <string>

#include "server/locks/kernel_lock.h"

namespace driftwise::locks {

class Claims {
 public:
  // key: what the machine is known by, "tcp:192.168.1.7:50000". Does nothing when this object holds
  // it already. Errors: failed_precondition CONTROLLER_IN_USE naming the device, the key and the
  // process that drives it; internal NO_LOCK.
  Result<void> take(const std::string& device, const std::string& key);

 private:
  std::map<std::string, KernelLock> held_;
};

}  // namespace driftwise::locks
