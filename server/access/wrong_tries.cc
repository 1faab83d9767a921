#include "server/access/wrong_tries.h"

#include <algorithm>

namespace driftwise::access {
namespace {

std::chrono::milliseconds pause_after(std::int64_t tries) {
  if (tries < WrongTries::kFree) return std::chrono::milliseconds(0);
  const auto doublings = std::min<std::int64_t>(tries - WrongTries::kFree, 10);
  return std::min<std::chrono::milliseconds>(std::chrono::seconds(1LL << doublings),
                                             WrongTries::kLongest);
}

}  // namespace

std::chrono::milliseconds WrongTries::must_wait(const std::string& source, Instant now) const {
  const auto found = sources_.find(source);
  if (found == sources_.end() || found->second.until <= now) return std::chrono::milliseconds(0);
  return std::chrono::ceil<std::chrono::milliseconds>(found->second.until - now);
}

WrongTries::Count WrongTries::wrong(const std::string& source, Instant now) {
  if (!sources_.contains(source) && sources_.size() >= kMostKept)
    sources_.erase(std::min_element(
        sources_.begin(), sources_.end(),
        [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
  Source& one = sources_[source];
  if (now - one.last > kForgotten) one.tries = 0;
  one.last = now;
  const auto pause = pause_after(++one.tries);
  one.until = now + pause;
  return {one.tries, pause};
}

void WrongTries::right(const std::string& source) { sources_.erase(source); }

std::string source_of(const std::string& from) {
  if (from.starts_with("unix")) return "unix";
  const auto colon = from.rfind(':');
  std::string host = from.substr(
      0, from.starts_with("ipv4:") || from.find(']') < colon ? colon : std::string::npos);
  if (!host.starts_with("ipv6:")) return host;
  // Whoever has an IPv6 address mostly has the 2^64 of its network. Without "::" the first four
  // groups are the network; with it, what stands before it is at most that.
  int groups = 0;
  for (std::size_t at = 5; at < host.size(); ++at) {
    if (host[at] != ':') continue;
    if (host.compare(at, 2, "::") == 0 && at > 6) return host.substr(0, at);
    if (++groups == 4) return host.substr(0, at);
  }
  return host;
}

}  // namespace driftwise::access
