#pragma once
// SHA-256 (FIPS 180-4) by OpenSSL's libcrypto. Thread: each object belongs to one. Throws
// std::runtime_error where the library has no SHA-256.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace driftwise::digest {

constexpr std::size_t kSha256Bytes = 32;

// A digest piece by piece: add(), add(), finish(). For the next one, begin().
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  Sha256& begin();  // what was added before is forgotten
  Sha256& add(std::string_view bytes);
  std::string finish();  // 32 bytes

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

std::string sha256(std::string_view bytes);      // 32 bytes
std::string sha256_hex(std::string_view bytes);  // 64 digits

std::string hex_from(std::string_view bytes);  // two lower-case digits per byte

}  // namespace driftwise::digest
