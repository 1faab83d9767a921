#include "server/access/page_links.h"

#include <algorithm>

#include "server/access/token.h"

namespace driftwise::access {

std::string PageLinks::make(Identity who, Instant now) {
  std::string link = "dwl_" + base64url(random_bytes(32));
  const std::scoped_lock lock(mutex_);
  std::erase_if(open_, [&](const auto& one) { return one.second.ends <= now; });
  if (open_.size() >= kMostOpen)
    open_.erase(std::ranges::min_element(
        open_, [](const auto& a, const auto& b) { return a.second.ends < b.second.ends; }));
  open_.emplace(sha256(link), Open{std::move(who), now + kLife});
  return link;
}

std::optional<Identity> PageLinks::use(std::string_view link, Instant now) {
  const std::string key = sha256(link);
  const std::scoped_lock lock(mutex_);
  const auto found = open_.find(key);
  if (found == open_.end()) return std::nullopt;
  Open one = std::move(found->second);
  open_.erase(found);
  if (one.ends <= now) return std::nullopt;
  return std::move(one.who);
}

}  // namespace driftwise::access
