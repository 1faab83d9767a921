#include "server/descriptor_limit.h"

#include <sys/resource.h>

#include <algorithm>

namespace driftwise {

std::size_t raise_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  if (limit.rlim_cur < kMostDescriptors) {
    limit.rlim_cur = std::min<rlim_t>(kMostDescriptors, limit.rlim_max);
    static_cast<void>(setrlimit(RLIMIT_NOFILE, &limit));
    static_cast<void>(getrlimit(RLIMIT_NOFILE, &limit));
  }
  return static_cast<std::size_t>(limit.rlim_cur);
}

}  // namespace driftwise
