#pragma once
// Sessions of the page: who is logged in behind which cookie. In memory: a restart of the daemon
// ends them. The cookie's value is 256 random bits; only its SHA-256 is kept. Web thread; instants
// are handed in.

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "server/access/identity.h"

namespace driftwise::web {

class SessionDesk {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  struct Rules {
    std::chrono::seconds longest = std::chrono::hours(12);
    std::size_t in_all = 512;  // beyond it the one that ends first goes
    std::size_t of_one_name = 32;
  };
  struct Session {
    access::Identity who;  // proof: page_session; credential: of what it was begun with
    Instant ends;
  };

  explicit SessionDesk(Rules rules) : rules_(rules) {}

  std::string begin(access::Identity who, Instant now);  // the cookie's value
  // nullptr: unknown, or over. Until the next call of another function.
  const Session* find(std::string_view cookie, Instant now);
  bool end(std::string_view cookie);  // false: there was none
  // Every session whose identity fails the test: its token or certificate was revoked.
  void end_unless(const std::function<bool(const access::Identity&)>& in_force);
  std::size_t size() const { return sessions_.size(); }

 private:
  void make_room(const std::string& name);

  Rules rules_;
  std::map<std::string, Session> sessions_;  // by SHA-256 of the cookie
};

// The value of this cookie in a Cookie header; empty: not there, or there twice.
std::string_view cookie_value(std::string_view header, std::string_view name);

}  // namespace driftwise::web
