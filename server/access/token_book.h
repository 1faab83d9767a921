#pragma once
// Tokens of a cell: made, listed, revoked, checked. Kept in one JSON file of mode 0600, which holds
// names, roles and scrypt hashes; a token's text is shown once, when it is made.
//
// Any thread. The first check of a token after the start computes its scrypt (about 50 ms, one at a
// time); later ones compare its SHA-256 in memory. A file changed on disk is in force after a
// restart only.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/role.h"
#include "server/access/token.h"

namespace driftwise::access {

struct TokenRecord {
  std::string id, name;
  Role role = Role::viewer;
  std::int64_t created_utc_s = 0;
  std::optional<std::int64_t> expires_utc_s;
  std::string made_by;

  bool operator==(const TokenRecord&) const = default;
};

struct FreshToken {
  TokenRecord record;
  std::string text;  // "dwt_...": nobody can show it again
};

class TokenBook {
 public:
  static constexpr std::size_t kMostTokens = 1000;
  static constexpr std::int64_t kLongest_s = 36'525LL * 86'400;

  // A file that is not there is an empty book. Errors: failed_precondition TOKENS_READABLE (others
  // may read it), data_loss BAD_TOKENS (path and line), unavailable CANNOT_READ.
  static Result<std::unique_ptr<TokenBook>> open(const std::string& path, ScryptCost cost = {});

  // On disk before it answers. now_utc_s: seconds of UTC. Errors: invalid_argument BAD_NAME,
  // BAD_TIME (in the past, or more than a hundred years ahead); resource_exhausted TOO_MANY;
  // unavailable CANNOT_WRITE.
  Result<FreshToken> create(const std::string& name, Role role, const std::string& made_by,
                            std::int64_t now_utc_s, std::optional<std::int64_t> expires_utc_s);
  std::vector<TokenRecord> list() const;  // in order of their making
  // In force at once, for calls that begin later. Errors: not_found NO_TOKEN.
  Result<TokenRecord> revoke(const std::string& id);

  // The book has this token, and its time has not ended.
  bool in_force(std::string_view id, std::int64_t now_utc_s) const;

  // The token was checked before and is good: no scrypt is needed. Never counts as a try.
  std::optional<TokenRecord> known(std::string_view text, std::int64_t now_utc_s) const;
  // Errors: unauthenticated BAD_TOKEN: the same sentence for what is no token, an unknown, a
  // revoked, an expired and a wrong one, after the same work.
  Result<TokenRecord> check(std::string_view text, std::int64_t now_utc_s);

 private:
  struct Kept {
    TokenRecord record;
    std::string salt, hash;
    ScryptCost cost;
  };
  TokenBook(std::string path, ScryptCost cost) : path_(std::move(path)), cost_(cost) {}
  Result<void> write(const std::vector<Kept>& tokens) const;
  std::vector<Kept> all() const;
  Result<void> read();

  std::string path_;
  ScryptCost cost_;
  mutable std::mutex mutex_;  // never held while the file is written: every call needs it
  std::mutex writing_;        // one change at a time, the file included
  std::mutex hashing_;        // one scrypt at a time: 16 MiB
  std::vector<Kept> tokens_;
  std::map<std::string, std::string> known_;  // SHA-256 of a good text -> id
};

}  // namespace driftwise::access
