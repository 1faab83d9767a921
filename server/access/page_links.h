#pragma once
// Links that log a browser in once: `driftwise open`. A link carries the identity of whoever asked
// for it, lives two minutes and is gone when it was used; only its hash is kept, in memory.
// Any thread.

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/identity.h"

namespace driftwise::access {

class PageLinks {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kLife{120};
  static constexpr std::size_t kMostOpen = 64;  // beyond it the oldest goes

  // "dwl_" and 43 characters of base64url: 256 random bits.
  std::string make(Identity who, Instant now);
  // The identity it carries, once; nothing: unknown, used or too old.
  std::optional<Identity> use(std::string_view link, Instant now);

 private:
  struct Open {
    Identity who;
    Instant ends;
  };
  std::mutex mutex_;
  std::map<std::string, Open> open_;  // by SHA-256
};

}  // namespace driftwise::access
