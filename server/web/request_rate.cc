#include "server/web/request_rate.h"

#include <algorithm>

namespace driftwise::web {

bool RequestRate::takes(const std::string& source, Instant now) {
  auto found = sources_.find(source);
  if (found == sources_.end()) {
    if (sources_.size() >= kMostKept)
      sources_.erase(std::ranges::min_element(
          sources_, [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
    found = sources_.emplace(source, Source{kBurst, now}).first;
  }
  Source& one = found->second;
  const double passed_s = std::chrono::duration<double>(now - one.last).count();
  one.left = std::min(kBurst, one.left + kPerSecond * passed_s);
  one.last = now;
  if (one.left < 1) return false;
  one.left -= 1;
  return true;
}

}  // namespace driftwise::web
