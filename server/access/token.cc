#include "server/access/token.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>

#include "server/core/reasons.h"

namespace driftwise::access {
namespace {

constexpr std::string_view kMark = "dwt_";
constexpr std::size_t kIdLength = 8, kSecretLength = 43;
constexpr std::string_view kBase64Url =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

bool is_id(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

const unsigned char* bytes_of(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

}  // namespace

std::string random_bytes(std::size_t count) {
  std::string out(count, '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(out.data()), static_cast<int>(count)) != 1)
    throw std::runtime_error("the system has no random numbers");
  return out;
}

std::string base64url(std::string_view bytes) {
  std::string out;
  std::uint32_t kept = 0;
  int bits = 0;
  for (const char c : bytes) {
    kept = kept << 8U | static_cast<unsigned char>(c);
    for (bits += 8; bits >= 6; bits -= 6) out += kBase64Url[kept >> (bits - 6) & 63U];
  }
  if (bits > 0) out += kBase64Url[kept << (6 - bits) & 63U];
  return out;
}

TokenParts new_token() {
  TokenParts parts;
  while (parts.id.size() < kIdLength) {  // the lower case and digits of what base64url gives
    const std::string drawn = base64url(random_bytes(12));
    std::copy_if(drawn.begin(), drawn.end(), std::back_inserter(parts.id), is_id);
  }
  parts.id.resize(kIdLength);
  parts.secret = base64url(random_bytes(32));
  return parts;
}

std::string token_text(const TokenParts& parts) {
  return std::string(kMark) + parts.id + "_" + parts.secret;
}

Result<TokenParts> token_parts(std::string_view text) {
  const bool good =
      text.size() == kMark.size() + kIdLength + 1 + kSecretLength && text.starts_with(kMark) &&
      text[kMark.size() + kIdLength] == '_' &&
      std::ranges::all_of(text.substr(kMark.size(), kIdLength), is_id) &&
      text.find_first_not_of(kBase64Url, kMark.size() + kIdLength + 1) == std::string_view::npos;
  if (!good) return fail(ErrorCode::unauthenticated, reasons::kBadToken, "this is no token");
  return TokenParts{std::string(text.substr(kMark.size(), kIdLength)),
                    std::string(text.substr(kMark.size() + kIdLength + 1))};
}

Result<std::string> scrypt_of(std::string_view secret, std::string_view salt, ScryptCost cost) {
  constexpr std::uint64_t kMostBytes = 64U << 20U;
  std::string out(32, '\0');
  if (EVP_PBE_scrypt(secret.data(), secret.size(), bytes_of(salt), salt.size(), cost.n, cost.r,
                     cost.p, kMostBytes, reinterpret_cast<unsigned char*>(out.data()),
                     out.size()) != 1)
    return fail(ErrorCode::internal, reasons::kOutOfMemory,
                "scrypt could not be computed: is the computer out of memory?");
  return out;
}

bool same_bytes(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace driftwise::access
