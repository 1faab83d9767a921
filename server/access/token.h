#pragma once
// Tokens: 256 random bits behind a public id, "dwt_k3f9a2c1_<43 characters>"; kept only as scrypt
// of them. Random numbers and scrypt are OpenSSL's.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/core/result.h"
#include "server/digest/sha256.h"

namespace driftwise::access {

// scrypt's N, r, p: 16 MiB and about 50 ms for each try (RFC 7914; OWASP's floor is twice that for
// passwords that people choose; these are random).
struct ScryptCost {
  std::uint64_t n = 1U << 14U, r = 8, p = 1;
};

struct TokenParts {
  std::string id, secret;  // 8 and 43 characters of [a-z0-9] and of base64url
};

// count random bytes. Throws std::runtime_error when the system has none.
std::string random_bytes(std::size_t count);
std::string base64url(std::string_view bytes);
using digest::sha256;  // of a cookie, a link, a token: what is kept instead of it

TokenParts new_token();
std::string token_text(const TokenParts& parts);
// Errors: unauthenticated BAD_TOKEN; the message holds nothing of the text.
Result<TokenParts> token_parts(std::string_view text);

// 32 bytes. Errors: internal NO_HASH (no memory).
Result<std::string> scrypt_of(std::string_view secret, std::string_view salt, ScryptCost cost);
// In a time that does not depend on the contents.
bool same_bytes(std::string_view a, std::string_view b);

}  // namespace driftwise::access
