#include "server/web/session_desk.h"

#include <algorithm>

#include "server/access/token.h"

namespace driftwise::web {

std::string SessionDesk::begin(access::Identity who, Instant now) {
  std::erase_if(sessions_, [&](const auto& one) { return one.second.ends <= now; });
  make_room(who.name);
  who.proof = access::Proof::page_session;
  std::string cookie = access::base64url(access::random_bytes(32));
  sessions_.emplace(access::sha256(cookie), Session{std::move(who), now + rules_.longest});
  return cookie;
}

const SessionDesk::Session* SessionDesk::find(std::string_view cookie, Instant now) {
  if (cookie.empty()) return nullptr;
  const auto found = sessions_.find(access::sha256(cookie));
  if (found == sessions_.end()) return nullptr;
  if (found->second.ends > now) return &found->second;
  sessions_.erase(found);
  return nullptr;
}

bool SessionDesk::end(std::string_view cookie) {
  return sessions_.erase(access::sha256(cookie)) > 0;
}

void SessionDesk::end_unless(const std::function<bool(const access::Identity&)>& in_force) {
  std::erase_if(sessions_, [&](const auto& one) { return !in_force(one.second.who); });
}

void SessionDesk::make_room(const std::string& name) {
  const auto ends_first = [&](bool same_name) {
    auto first = sessions_.end();
    for (auto one = sessions_.begin(); one != sessions_.end(); ++one)
      if ((!same_name || one->second.who.name == name) &&
          (first == sessions_.end() || one->second.ends < first->second.ends))
        first = one;
    return first;
  };
  const auto of_name = std::ranges::count_if(
      sessions_, [&](const auto& one) { return one.second.who.name == name; });
  if (static_cast<std::size_t>(of_name) >= rules_.of_one_name) sessions_.erase(ends_first(true));
  if (sessions_.size() >= rules_.in_all) sessions_.erase(ends_first(false));
}

std::string_view cookie_value(std::string_view header, std::string_view name) {
  std::string_view out;
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view one = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (!one.starts_with(name) || !one.substr(name.size()).starts_with('=')) continue;
    if (!out.empty()) return {};  // somebody else's stands beside ours: neither counts
    out = one.substr(name.size() + 1);
  }
  return out;
}

}  // namespace driftwise::web
